// Do caps pass through one another, through themselves or through the outer surface? Judged on where their
// vertices are now, pair by pair, by what makes two triangles cross: an edge of one that pierces the inside
// of the other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/caps.hpp"
#include "common/rough/surface_tree.hpp"

namespace fracture {

struct CapSurface {
  const std::vector<std::array<VertexId, 3>>& triangles;
  VertexId first;                    ///< the vertex of points[0]
  const std::vector<Vec3d>& flat;    ///< where the vertices were in the flat caps
  const std::vector<Vec3d>& points;  ///< where they are
  const std::vector<char>& moved;    ///< per point: not where it was
  const std::vector<double>&
      surface;  ///< per point: how far the flat one is from the outer surface, up to some reach
};

/// A triangle with its plane.
struct PlaneTriangle {
  std::array<Vec3d, 3> corners;
  Vec3d normal;  ///< unit; zero where the triangle is flat: then every height is 0
  explicit PlaneTriangle(const std::array<Vec3d, 3>& t);
};

/// Keeps references: what the caps are made of may change between two looks, each vertex somewhere between
/// where it was at the start and its place in the flat cap.
class Crossings {
 public:
  /// Pairs that cross by `tolerance` (m) or less do not count.
  Crossings(const CapSurface& caps, const SurfaceTree& outside, double tolerance);

  /// How many pairs cross and could do otherwise: they have a moved vertex. Sets `crossing` (per triangle) of
  /// both. The first time all pairs are looked at, later only those with one of the `suspects` (per
  /// triangle), which are the triangles whose vertices have been moved since.
  std::uint64_t find(const std::vector<char>& suspects, std::vector<char>& crossing,
                     const Execution& execution);

 private:
  std::array<Vec3d, 3> corners(std::size_t t) const;
  bool is_moved(std::size_t t) const;
  /// Leaves pairs out that could do nothing about it, or share a side.
  bool pair_crosses(std::uint32_t s, std::uint32_t t) const;
  bool leaves_surface(std::uint32_t t) const;

  const CapSurface caps_;
  const SurfaceTree& outside_;
  const double tolerance_;
  BoxTree tree_;                    // of all the places where a triangle can come to be
  std::vector<PlaneTriangle> now_;  // as they are; empty before the first look
};

/// Does an edge of one pierce the inside of the other, by more than `tolerance` on all sides?
bool cross_each_other(const PlaneTriangle& s, const PlaneTriangle& t, double tolerance);

}  // namespace fracture
