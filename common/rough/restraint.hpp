// Cells whose cuts get less roughness than requested. This is the fallback if rough cuts fail
// (pipeline/rough_cells.hpp).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/delaunay/tetrahedralization.hpp"

namespace fracture {

enum class Restraint : std::uint8_t {
  kNone,
  kLess,  ///< kLessAmplitude times the amplitude
  kFlat,  ///< flat cuts: neither moved nor refined
};
inline constexpr double kLessAmplitude = 0.25;

/// One entry per site; empty: no cell is restrained.
using Restraints = std::vector<Restraint>;

/// The restraint of the cap between two cells: the stronger one of the two.
inline Restraint restraint_of(const Restraints& restraints, SiteId lo, SiteId hi) {
  return restraints.empty() ? Restraint::kNone : std::max(restraints[lo], restraints[hi]);
}

}  // namespace fracture
