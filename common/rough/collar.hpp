// The triangles between the loops of a cap and the rim of its core (core_lattice.hpp).
//
// Usually this is a ring between one loop and one rim, which is zipped up. From a pair of corners near each
// other, each step adds a triangle on the next edge of either the loop or the rim (Keppel 1975; Christiansen
// & Sederberg 1978, "Conversion of complex contour line definitions into polygonal element mosaics"). It
// chooses the one that is Delaunay among their four corners. If all triangles of a full turn are
// counter-clockwise, they cover the ring once, because the coverage of a point is the winding number of one
// boundary minus that of the other. If the zip fails, or if there is another number of loops, the collar is
// triangulated like a cap and flipped to Delaunay.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

class Collar {
 public:
  /// `loop_begin`: as for triangulate(). The first `caps_loops` loops are the cap's; the others are the loops
  /// of the rim and run clockwise. Returns false, with an unspecified state, if the loops do not nest. Throws
  /// Interrupted.
  bool build(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
             std::size_t caps_loops, const Execution& execution);

  /// Triangles as indices of the points.
  const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return triangulation_.triangles; }
  /// Whether it was one ring and zipping it succeeded.
  bool zipped() const { return zipped_; }
  std::uint32_t regions() const { return triangulation_.regions; }
  void clear() { triangulation_.clear(); }

 private:
  bool zip(std::span<const LatticePoint> points, std::uint32_t rim_begin);

  Triangulation triangulation_;
  bool zipped_ = false;
};

}  // namespace fracture
