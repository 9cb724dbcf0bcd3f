// Do caps pass through one another, through themselves or through the outer surface? Judged on where their
// vertices are now, pair by pair, by what makes two triangles cross: an edge of one that pierces the inside
// of the other.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/caps.hpp"
#include "common/rough/surface_grid.hpp"

namespace fracture {

struct CapSurface {
  const std::vector<std::array<VertexId, 3>>& triangles;
  VertexId first;                    ///< the vertex of points[0]
  const std::vector<Vec3d>& points;  ///< where the vertices are
  const std::vector<char>& moved;    ///< per point: not where it was in the flat cap
  const std::vector<double>&
      surface;  ///< per point: how far the flat one is from the outer surface, up to reach
};

/// How many pairs cross by more than `tolerance` (m) and could do otherwise: they have a moved vertex. Sets
/// `crossing` (per triangle) of both. Only pairs with a triangle in `suspects` are looked at; empty: all.
std::uint64_t find_crossings(const CapSurface& caps, const SurfaceGrid& outside, const Box& box, double width,
                             double tolerance, const std::vector<char>& suspects, std::vector<char>& crossing,
                             const Execution& execution);

/// Does an edge of one triangle pierce the inside of the other, by more than `tolerance` on all sides?
bool triangles_cross(const std::array<Vec3d, 3>& s, const std::array<Vec3d, 3>& t, double tolerance);

}  // namespace fracture
