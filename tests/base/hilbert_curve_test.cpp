#include "common/base/hilbert_curve.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture {
namespace {

TEST(HilbertCurve, IsABijectionWhoseNeighboursAreOneLatticeStepApart) {
  constexpr int kBits = 4, kSide = 1 << kBits;
  std::vector<Vec3d> at(kSide * kSide * kSide);
  std::vector<int> seen(at.size(), 0);
  for (int x = 0; x < kSide; ++x)
    for (int y = 0; y < kSide; ++y)
      for (int z = 0; z < kSide; ++z) {
        const std::uint64_t h = hilbert_index(x, y, z, kBits);
        ASSERT_LT(h, at.size());
        at[h] = {x * 1.0, y * 1.0, z * 1.0};
        ++seen[h];
      }
  EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  for (std::size_t h = 1; h < at.size(); ++h) {
    const Vec3d d = at[h] - at[h - 1];
    ASSERT_EQ(std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z), 1.0) << "at index " << h;
  }
}

TEST(HilbertCurve, RunsThroughTheCubeOverABox) {
  constexpr int kBits = 3, kLast = (1 << kBits) - 1;
  Box box;
  box.add(Vec3d{1, 2, 3});
  box.add(Vec3d{15, 9, 10});  // longest side 14: cells of size 2
  const HilbertCurve curve(box, kBits);
  EXPECT_EQ(curve.at({1, 2, 3}), hilbert_index(0, 0, 0, kBits));
  EXPECT_EQ(curve.at({15, 9, 10}), hilbert_index(kLast, 3, 3, kBits));
  EXPECT_EQ(curve.at({5.5, 4.5, 3}), hilbert_index(2, 1, 0, kBits));
  EXPECT_EQ(curve.at({-100, 1e9, 3}), hilbert_index(0, kLast, 0, kBits)) << "a point outside";
}

TEST(HilbertCurve, OfABoxWithoutSizeHasOneCell) {
  Box box;
  box.add(Vec3d{1, 2, 3});
  EXPECT_EQ(HilbertCurve(box, 20).at({1, 2, 3}), 0u);
  EXPECT_EQ(HilbertCurve(box, 20).at({0, 0, 0}), 0u);
  EXPECT_EQ(HilbertCurve(Box{}, 20).at({0, 0, 0}), 0u) << "nothing was added to this box";
}

}  // namespace
}  // namespace fracture
