// Finds which of several fragments of one part and cell contains a point.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Searches surfaces of fragments, which are made on first use. Borrows all.
class Islands {
 public:
  /// `rounding`: m, the distance by which rounding for output has moved surfaces.
  Islands(std::span<const Fragment* const> fragments, double rounding, const Execution& execution);
  ~Islands();

  /// Returns the fragment that contains the point. `islands`: the fragments in a cell, which must be the
  /// same in each call with this cell. `is_on`: whether the point is on a fragment's surface; otherwise it
  /// is inside one. Throws Interrupted.
  std::uint32_t pick(std::uint32_t cell, std::span<const std::uint32_t> islands, const Vec3d& place,
                     bool is_on);
  /// Number of islands whose boxes meet the box, with a margin for rounding.
  std::size_t count_near(std::uint32_t cell, std::span<const std::uint32_t> islands, const Box& box);

 private:
  struct Surfaces;
  /// The islands of a cell.
  struct OfCell {
    std::vector<Box> boxes;
    std::unique_ptr<Surfaces> surfaces;  ///< made if the boxes do not decide
  };
  OfCell& islands_of(std::uint32_t cell, std::span<const std::uint32_t> islands);
  std::size_t nearest(const Surfaces& surfaces, const Vec3d& place);

  const std::span<const Fragment* const> fragments_;
  const double rounding_;
  const Execution& execution_;
  Pacer pacer_;
  std::map<std::uint32_t, OfCell> of_cell_;
};

}  // namespace fracture
