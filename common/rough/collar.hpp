// The triangles between the loops of a cap and the rim of its core (core_lattice.hpp).
//
// Mostly that is a ring between one loop and one rim. It is zipped up: from a pair of corners near each other, step
// by step, a triangle on the next edge of the one or of the other (Keppel 1975; Christiansen & Sederberg 1978,
// "Conversion of complex contour line definitions into polygonal element mosaics"), whichever of the two is the
// Delaunay one of their four corners. Where all triangles of a whole turn are counter-clockwise they cover the ring
// once: how often a place is covered is how often the one boundary winds around it less the other. Where the zip
// jams, and for any other number of loops, the collar is triangulated as caps are, and flipped to Delaunay.
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
  /// `loop_begin`: as triangulate() has it, the cap's loops first, `caps_loops` of them, then the loops of the
  /// rim, which run clockwise. False, with nothing promised, where the loops do not nest. Throws Interrupted.
  bool build(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
             std::size_t caps_loops, const Execution& execution);

  /// Indices of the points.
  const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return triangulation_.triangles; }
  /// Was it one ring, and did the zip get around?
  bool zipped() const { return zipped_; }
  std::uint32_t regions() const { return triangulation_.regions; }
  void clear() { triangulation_.clear(); }

 private:
  bool zip(std::span<const LatticePoint> points, std::uint32_t rim_begin);

  Triangulation triangulation_;
  bool zipped_ = false;
};

}  // namespace fracture
