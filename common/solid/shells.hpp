// Shells: the connected components of the glued surface, with their measurements.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

struct Shell {
  TriangleId first = kNoTriangle;  ///< its lowest triangle; shells are numbered in this order
  std::uint32_t triangles = 0;
  double volume = 0;  ///< signed: negative if its triangles face the enclosed volume. Accurate to 1e-10 for
                      ///< shells that are not flat, even if terms cancel
  double area = 0;
  Box box;
  bool flat = false;  ///< encloses no volume (see kFlatRatio)
};

/// A shell is flat if |volume| <= kFlatRatio · area^1.5, or if its mean thickness |volume| / area is at most
/// kThinnestRatio (half a unit in the last place) of its largest coordinate. Such a body has no interior on
/// the float32 lattice of its file. The second condition includes every shell whose exact volume is zero: no
/// term of the sum is larger than 2 √3 · largest · its share of the area, so rounding errors are far smaller.
inline constexpr double kFlatRatio = 1e-10, kThinnestRatio = 0x1.0p-24;

struct Shells {
  std::vector<std::uint32_t> of_triangle;
  std::vector<Shell> list;
};

/// Finds the shells. Volumes are summed in triangle order about the shell's first vertex.
Shells find_shells(const Surface& surface, const Execution& execution);

/// Counts the flat shells that are not thin: parts of them enclose volumes, which cancel in the sum.
std::uint64_t count_cancelling(const Surface& surface, const Shells& shells, const Execution& execution);

}  // namespace fracture::solid_detail
