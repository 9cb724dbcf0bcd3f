// A convex hull that finds its farthest corner quickly. Private to this folder.
#pragma once

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>

#include <array>
#include <vector>

namespace fracture::world {

/// Bullet's hull, with the same answers. A third of a step's instructions went into the search for the corner that is
/// farthest in a direction: Bullet's looks at all of some fifty in double precision, one by one. Here four at a time are
/// compared in floats, and only those that may be the farthest, by what rounding can do, are looked at in doubles.
///
/// Bullet knows it as a polyhedron of ours (kType): it would not ask this class if it took it for its own.
class HullShape final : public btConvexHullShape {
 public:
  static constexpr int kType = CUSTOM_POLYHEDRAL_SHAPE_TYPE;
  BT_DECLARE_ALIGNED_ALLOCATOR();

  HullShape() { m_shapeType = kType; }
  /// After the last point and the margin: before it is asked for anything.
  void finish();

  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override;
  btScalar getAngularMotionDisc() const override { return reach_; }

 private:
  using Four = float __attribute__((vector_size(16)));  // g++ and clang++, of any processor
  struct Corners {
    Four x, y, z;
  };
  static constexpr std::size_t kMostFours = 64;  ///< of a larger hull all corners are looked at

  int farthest_of_all(const btVector3& direction) const;

  std::vector<Corners> fours_;  ///< the last one is filled up with the last corner
  btScalar largest_ = 0;        ///< of all coordinates, without their signs
  btScalar reach_ = 0;
};

}  // namespace fracture::world
