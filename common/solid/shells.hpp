// Shells: the connected components of the glued surface, with their figures.
#pragma once

#include "common/base/execution.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

struct Shell {
  TriangleId first = kNoTriangle;  ///< its lowest triangle: shells are numbered in this order
  std::uint32_t triangles = 0;
  double volume = 0;  ///< signed: negative when its triangles face the volume they enclose; of one that is
                      ///< not flat to 1e-10, however doubles cancel
  double area = 0;
  Box box;
  bool flat = false;  ///< bounds no volume (see kFlatRatio)
};

/// A shell is flat when |volume| <= kFlatRatio · area^1.5, or when its mean thickness |volume| / area is at
/// most kThinnestRatio (half a unit in the last place) of its largest coordinate: such a body has no inside
/// on the float32 lattice of its file. A shell whose exact volume is zero is flat by the latter: no term of
/// the sum is larger than 2 √3 · largest · its share of the area, so that rounding stays far below.
inline constexpr double kFlatRatio = 1e-10, kThinnestRatio = 0x1.0p-24;

struct Shells {
  std::vector<std::uint32_t> of_triangle;
  std::vector<Shell> list;
};

/// Volumes are summed in triangle order about the shell's first vertex.
Shells find_shells(const Surface& surface, const Execution& execution);

}  // namespace fracture::solid_detail
