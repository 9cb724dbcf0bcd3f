// Cells whose cuts get less of the roughness than was asked: the net under rough cuts
// (pipeline/rough_cells.hpp).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "common/delaunay/tetrahedralization.hpp"

namespace fracture {

enum class Restraint : std::uint8_t {
  kNone,
  kLess,  ///< kLessAmplitude of the amplitude
  kFlat,  ///< cuts as they are without roughness: neither moved nor refined
};
inline constexpr double kLessAmplitude = 0.25;

/// Per site; empty: nobody is restrained.
using Restraints = std::vector<Restraint>;

/// Of the cap between two cells: that of the one that is restrained more.
inline Restraint restraint_of(const Restraints& restraints, SiteId lo, SiteId hi) {
  return restraints.empty() ? Restraint::kNone : std::max(restraints[lo], restraints[hi]);
}

}  // namespace fracture
