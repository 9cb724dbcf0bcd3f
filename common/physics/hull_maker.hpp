// Makes one convex hull of a body's points, in the form that the file contains.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/scratch.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/convex_hull.hpp"

namespace fracture {

/// Memory that a thread reuses for the next hull.
struct HullMaker {
  ConvexHullBuilder builder;
  std::vector<std::uint32_t> index;
  std::vector<Vec3f> corners;
  std::vector<std::uint32_t> corner_of;  // for each vertex of a fragment
  double rounding = 0;                   // m: rounding_of() the set; each user must set it

  std::size_t bytes() const { return builder.bytes() + bytes_of_vectors(index, corners, corner_of); }
  void release() {
    builder.release();
    release_vectors(index, corners, corner_of);
  }
};

/// Sets `corners` and `corner_of` of the maker: lists each position of the fragment once, although faces with different
/// attributes have separate vertices there. Throws Interrupted.
void collect_corners(const Fragment& f, HullMaker& maker, const Execution& execution);

/// m: twice the distance by which rounding to the seam lattice may have moved a corner. If hulls of neighbours are inset by
/// this (their faces by at least half of it), they are apart because their cells are.
inline double rounding_of(const FragmentSet& set) { return length(set.lattice_step); }

/// Returns a hull with only the points that are corners of the triangles, in the given order. `index`: working memory.
CollisionHull compact(std::span<const Vec3f> points, const ConvexHullBuilder::Triangles& triangles,
                      std::vector<std::uint32_t>& index);

/// The volume that the triangles enclose, in the points' unit cubed; 0 without triangles.
double volume_within(std::span<const Vec3f> points, std::span<const std::array<std::uint32_t, 3>> triangles);

/// Moves the faces of a hull inwards (collision_hulls.hpp). `rounding`: rounding_of() the set. Returns the hull's original
/// volume, m³; 0 if it has none.
double inset(CollisionHull& hull, double rounding);

/// Mass properties of a convex body, in the frame of its points.
struct ConvexMass {
  double volume, area;  ///< m³, m², both > 0
  Vec3d center;         ///< of mass, m
};

/// Whether the hull is a triangulated sphere, and the mean of the corners is below every triangle.
bool bounds_a_body(const CollisionHull& hull);

/// Adds the inset surface of a body that is known to be convex. Its triangles must be wider than the effects of rounding,
/// and each point must be a corner. Returns false, and adds nothing, if the surface is not a triangulated sphere or has
/// more than kMaxHullPoints corners.
bool add_convex(std::span<const Vec3f> points, const BodySurface& surface, const ConvexMass& mass,
                double rounding, FragmentHulls& out);

/// Adds the inset hull of these points, or a small cube if they are flat. `surface`: see ConvexHullBuilder::build().
void add_hull(std::span<const Vec3f> points, const BodySurface& surface, HullMaker& maker, FragmentHulls& out,
              const Execution& execution);

}  // namespace fracture
