// The farthest corner of a hull is the one that Bullet finds.
#include "client/world/hull_shape.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>

namespace fracture::world {
namespace {

class HullShapeTest : public ::testing::Test {
 protected:
  double coordinate() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  btVector3 vector() { return {coordinate(), coordinate(), coordinate()}; }

  /// Adds the same point to both hulls.
  void add(const btVector3& point) {
    bullet_.addPoint(point, false);
    ours_.addPoint(point, false);
  }
  void finish() {
    bullet_.recalcLocalAabb();
    ours_.finish();
  }
  void expect_equal(const btVector3& direction) {
    const btVector3 expected = bullet_.localGetSupportVertexWithoutMarginNonVirtual(direction),
                    found = ours_.localGetSupportVertexWithoutMarginNonVirtual(direction);
    EXPECT_EQ(expected.x(), found.x());
    EXPECT_EQ(expected.y(), found.y());
    EXPECT_EQ(expected.z(), found.z());
  }

  std::mt19937_64 random_{11};
  btConvexHullShape bullet_;
  HullShape ours_;
};

TEST_F(HullShapeTest, FarthestCornersAreThoseThatBulletFinds) {
  for (const int points : {1, 4, 7, 24, 61, 257, 400}) {
    SCOPED_TRACE(points);
    bullet_ = {};
    HullShape hull;
    for (int k = 0; k < points; ++k) {
      const btVector3 p = 0.3 * vector();
      bullet_.addPoint(p, false);
      hull.addPoint(p, false);
    }
    bullet_.recalcLocalAabb();
    hull.finish();
    EXPECT_EQ(hull.getAngularMotionDisc(), bullet_.getAngularMotionDisc());
    for (int k = 0; k < 500; ++k)
      for (const double length : {1e-40, 1e-18, 1e-6, 1.0, 1e30}) {
        const btVector3 direction = length * vector();
        const btVector3 expected = bullet_.localGetSupportVertexWithoutMarginNonVirtual(direction);
        ASSERT_TRUE(hull.localGetSupportVertexWithoutMarginNonVirtual(direction) == expected)
            << "length " << length;
      }
  }
}

TEST_F(HullShapeTest, OfCornersThatAreAsFarTheFirstIsTaken) {
  // A cluster of points within about a nanometre of a corner, and flat faces.
  for (int k = 0; k < 8; ++k) add({k & 1 ? 0.1 : -0.1, k & 2 ? 0.1 : -0.1, k & 4 ? 0.1 : -0.1});
  for (int k = 0; k < 20; ++k) add(btVector3(0.1, 0.1, 0.1) + 1e-9 * vector());
  finish();
  for (const btVector3& direction : {btVector3(1, 0, 0), btVector3(0, -1, 0), btVector3(0, 0, 1),
                                     btVector3(1, 1, 0), btVector3(1, 1, 1), btVector3(0, 0, 0)})
    expect_equal(direction);
  for (int k = 0; k < 1000; ++k) expect_equal(btVector3(1, 1, 1) + 1e-7 * vector());
}

TEST_F(HullShapeTest, ADirectionThatIsNoNumberHasACorner) {
  for (int k = 0; k < 9; ++k) add(vector());
  finish();
  const double nan = std::numeric_limits<double>::quiet_NaN(), far = std::numeric_limits<double>::infinity();
  for (const btVector3& direction : {btVector3(nan, 0, 0), btVector3(0, far, 0), btVector3(far, -far, nan)})
    expect_equal(direction);
}

}  // namespace
}  // namespace fracture::world
