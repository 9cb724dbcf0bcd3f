// One convex hull of a body's points, as a file has it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/scratch.hpp"
#include "common/physics/collision_hulls.hpp"
#include "common/physics/convex_hull.hpp"

namespace fracture {

/// What a thread keeps from one hull to the next.
struct HullMaker {
  ConvexHullBuilder builder;
  std::vector<std::uint32_t> index;
  std::vector<Vec3f> corners;
  std::vector<std::uint32_t> corner_of;  // of a fragment's vertices
  double rounding = 0;                   // m: rounding_of() the set; of the user before, until it is set

  std::size_t bytes() const { return builder.bytes() + bytes_of_vectors(index, corners, corner_of); }
  void release() {
    builder.release();
    release_vectors(index, corners, corner_of);
  }
};

/// m: twice what rounding to the seam lattice may have moved a corner by. Hulls of neighbours that are inset by so much
/// (their faces by at least half of it) are apart as their cells are.
inline double rounding_of(const FragmentSet& set) { return length(set.lattice_step); }

/// A hull of those points that are corners of the triangles, in the order they came in. `index`: working memory.
CollisionHull compact(std::span<const Vec3f> points, const ConvexHullBuilder::Triangles& triangles,
                      std::vector<std::uint32_t>& index);

/// The volume that the triangles enclose, in the unit of the points cubed; 0 without triangles.
double volume_within(std::span<const Vec3f> points, std::span<const std::array<std::uint32_t, 3>> triangles);

/// Moves the faces of a hull inwards (collision_hulls.hpp). `rounding`: rounding_of() the set. Returns the hull's volume
/// before, m³; 0 if it has none.
double inset(CollisionHull& hull, double rounding);

/// Of a convex body, in the frame of its points.
struct ConvexMass {
  double volume, area;  ///< m³, m², both > 0
  Vec3d center;         ///< of mass, m
};

/// Is it a sphere of triangles, each of which sees the middle of the corners below itself?
bool bounds_a_body(const CollisionHull& hull);

/// The hull of a body that is known to be convex, inset: its own surface, whose triangles are wider than what rounding
/// does to them. Of the points each is a corner. False, and no hull, where that surface is no sphere of triangles, or has
/// more than kMaxHullPoints corners.
bool add_convex(std::span<const Vec3f> points, const BodySurface& surface, const ConvexMass& mass,
                double rounding, FragmentHulls& out);

/// The hull of these points, inset; a small cube if they are flat. `surface`: as ConvexHullBuilder::build() has it.
void add_hull(std::span<const Vec3f> points, const BodySurface& surface, HullMaker& maker, FragmentHulls& out,
              const Execution& execution);

}  // namespace fracture
