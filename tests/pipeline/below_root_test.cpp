// Places of a request, which have the origin of the file, become places below the root node.
#include "common/pipeline/below_root.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

namespace fracture {
namespace {

const Vec3d kOffset{500000, 30, 4649776};
Vec3d far(double x, double y, double z) { return kOffset + Vec3d{x, y, z}; }

TEST(BelowRoot, EveryPlaceIsMovedAndNothingElse) {
  FractureParameters p;
  p.pattern = ImpactPattern{.impacts = {far(0.5, 1, 2)}, .radius = 0.25};
  p.hits = {{far(1, 2, 3), 0.5, 30}};
  p.keep = Region{.shape = Region::Shape::kSphere, .center = far(4, 5, 6), .radius = 7};
  p.anchors.planes = {{{0, 2, 0}, 31, far(0, 1, 0)}};  // y <= 31 in the file
  p.anchors.boxes = {{far(-1, -1, -1), far(1, 1, 1)}};
  p.anchors.points = {far(0, 0, 0.125)};
  auto breaks = std::make_shared<FractureParameters>();
  breaks->pattern = PointsPattern{.points = {far(7, 8, 9)}};
  p.assigned = {{.breaks = breaks}};

  const FractureParameters q = below_root(p, kOffset).value();
  EXPECT_EQ(std::get<ImpactPattern>(q.pattern), (ImpactPattern{.impacts = {{0.5, 1, 2}}, .radius = 0.25}));
  EXPECT_EQ(q.hits[0].point, (Vec3d{1, 2, 3}));
  EXPECT_EQ(q.hits[0].radius, 0.5);
  EXPECT_EQ(q.keep->center, (Vec3d{4, 5, 6}));
  EXPECT_EQ(q.keep->radius, 7);
  EXPECT_EQ(q.anchors.planes[0].offset, 1);
  EXPECT_EQ(q.anchors.planes[0].point, (Vec3d{0, 1, 0}));
  EXPECT_EQ(q.anchors.planes[0].normal, (Vec3d{0, 2, 0}));
  EXPECT_EQ(q.anchors.boxes[0].min, (Vec3d{-1, -1, -1}));
  EXPECT_EQ(q.anchors.points[0], (Vec3d{0, 0, 0.125}));
  EXPECT_EQ(std::get<PointsPattern>(q.assigned[0].breaks->pattern).points, (std::vector<Vec3d>{{7, 8, 9}}));
  EXPECT_EQ(std::get<PointsPattern>(breaks->pattern).points[0], far(7, 8, 9)) << "of the request, unchanged";

  p.keep = Region{.shape = Region::Shape::kBox, .box = {far(0, 0, 0), far(1, 1, 1)}};
  EXPECT_EQ(below_root(p, kOffset).value().keep->box.max, (Vec3d{1, 1, 1}));
}

TEST(BelowRoot, APlaceFarFromTheMeshIsRefusedWithItsParameter) {
  FractureParameters p;
  p.pattern = RadialPattern{.impacts = {{0, 0, 0}}};
  ASSERT_TRUE(below_root(p, {}));
  const auto refused = below_root(p, kOffset);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(refused.error().pointer, "impacts");
  EXPECT_NE(refused.error().detail.find("(500000, 30, 4649776)"), std::string::npos)
      << refused.error().detail;
}

TEST(BelowRoot, ABoxMayReachAnyFar) {
  FractureParameters p;
  p.anchors.boxes = {{{-1e8, -1e8, -1e8}, far(1e7, 0, 1e7)}};
  const Box box = below_root(p, kOffset).value().anchors.boxes[0];
  EXPECT_EQ(box.min, (Vec3d{-1e6, -1e6, -1e6}));
  EXPECT_EQ(box.max, (Vec3d{1e6, 0, 1e6}));
}

}  // namespace
}  // namespace fracture
