// One convex hull of a body's points, as a file has it.
#pragma once

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

  std::size_t bytes() const { return builder.bytes() + bytes_of_vectors(index, corners, corner_of); }
  void release() {
    builder.release();
    release_vectors(index, corners, corner_of);
  }
};

/// Moves the faces of a hull inwards (collision_hulls.hpp).
void inset(CollisionHull& hull);

/// The hull of these points, inset; a small box where they are flat. `surface`: as ConvexHullBuilder::build() has it.
void add_hull(std::span<const Vec3f> points, const BodySurface& surface, HullMaker& maker, FragmentHulls& out,
              const Execution& execution);

}  // namespace fracture
