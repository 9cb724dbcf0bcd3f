#include "common/exact/orient3d.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/base/random.hpp"
#include "common/exact/wide_int.hpp"
#include "tests/exact/rational_oracle.hpp"
#include "tests/exact/ulps.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::exact {
namespace {

using test::orient3d_oracle;
using test::ulps;

TEST(Orient3d, IsPositiveOnTheSideOfTheCrossProduct) {
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}), -1);
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {7, -3, 0}), 0);
}

TEST(Orient3d, AgreesWithRationalsOnUlpGridAroundCoplanarPoint) {
  const Vec3d a{0.1, 0.2, 0.3}, b{1.7, -0.4, 0.9}, c{-0.3, 2.1, 0.7};
  const Vec3d middle = a + 0.25 * (b - a) + 0.5 * (c - a);
  int zeros = 0, positive = 0, negative = 0;
  for (int i = -6; i <= 6; ++i)
    for (int j = -6; j <= 6; ++j)
      for (int k = -6; k <= 6; ++k) {
        const Vec3d d{ulps(middle.x, i), ulps(middle.y, j), ulps(middle.z, k)};
        const int expected = orient3d_oracle(a, b, c, d);
        ASSERT_EQ(orient3d(a, b, c, d), expected) << i << " " << j << " " << k;
        (expected == 0 ? zeros : expected > 0 ? positive : negative)++;
      }
  EXPECT_GT(positive, 0);
  EXPECT_GT(negative, 0);
}

TEST(Orient3d, AgreesWithRationalsOnUlpGridWhereManyPointsAreExactlyCoplanar) {
  const Vec3d a{12, 12, 12}, b{24, 24, 24}, c{12, 24, 18};
  int zeros = 0;
  for (int i = 0; i < 24; ++i)
    for (int j = 0; j < 24; ++j) {
      const Vec3d d{ulps(0.5, i), ulps(0.5, j), ulps(0.5, i)};
      const int expected = orient3d_oracle(a, b, c, d);
      ASSERT_EQ(orient3d(a, b, c, d), expected);
      zeros += expected == 0;
    }
  EXPECT_GT(zeros, 0);
}

TEST(Orient3d, AgreesWithRationalsForCoordinatesOfEveryWidthAndRange) {
  Random random(5);
  for (const int bits : {2, 10, 19, 20, 21, 40, 41, 42, 53})
    for (int i = 0; i < test::repetitions(300); ++i) {
      std::array<Vec3d, 4> p;
      for (Vec3d& q : p)
        for (int axis = 0; axis < 3; ++axis) {
          const double v = std::floor(random.uniform() * std::ldexp(1.0, bits));
          q[axis] = random.below(2) ? v : -v;
        }
      // Often exactly coplanar: if the numbers are small enough to be exact, the last point lies in the plane
      // of the others.
      if (i % 2 && bits < 50)
        for (int axis = 0; axis < 3; ++axis)
          p[3][axis] = p[0][axis] + (p[1][axis] - p[0][axis]) + 2 * (p[2][axis] - p[0][axis]);
      ASSERT_EQ(orient3d(p[0], p[1], p[2], p[3]), orient3d_oracle(p[0], p[1], p[2], p[3]))
          << bits << " bits, " << i;
    }
  for (int i = 0; i < test::repetitions(500);
       ++i) {  // wider than any fixed width: 6e-17 with 1e12, and subnormals
    std::array<Vec3d, 4> p;
    for (Vec3d& q : p)
      for (int axis = 0; axis < 3; ++axis) {
        const double v = static_cast<double>(random.below(7)) - 3;
        const std::uint64_t kind = random.below(4);
        q[axis] = kind == 0 ? v * 6e-17 : kind == 1 ? v * 1e12 : kind == 2 ? v * 5e-324 : v;
      }
    ASSERT_EQ(orient3d(p[0], p[1], p[2], p[3]), orient3d_oracle(p[0], p[1], p[2], p[3])) << i;
  }
}

TEST(Orient3d, ChangesSignWithEveryOddPermutation) {
  Random random(6);
  for (int i = 0; i < test::repetitions(200); ++i) {
    std::array<Vec3d, 4> p;
    for (Vec3d& q : p)
      for (int axis = 0; axis < 3; ++axis) q[axis] = static_cast<double>(random.below(3)) / 3;
    std::array<int, 4> order{0, 1, 2, 3};
    const int sign = orient3d(p[0], p[1], p[2], p[3]);
    do {
      int inversions = 0;
      for (int a = 0; a < 4; ++a)
        for (int b = a + 1; b < 4; ++b) inversions += order[b] < order[a];
      ASSERT_EQ(orient3d(p[order[0]], p[order[1]], p[order[2]], p[order[3]]), inversions % 2 ? -sign : sign);
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

TEST(Orient3d, CountsOnlyWhatTheFilterLeaves) {
  PredicateCounters counters;
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {}, &counters), 1);
  EXPECT_EQ(counters.exact, 0u);
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {}, &counters), 0);
  EXPECT_EQ(counters.exact, 1u);
  EXPECT_EQ(counters.ties, 1u);
  EXPECT_EQ(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0x1p-60}, {}, &counters), 1);
  EXPECT_EQ(counters.exact, 2u);
  EXPECT_EQ(counters.ties, 1u);
}

// The widths promised in wide_int.hpp, at their limits, compared with integers of any size.
TEST(WideInt, ProductsAndSumsAgreeWithIntegersOfAnySize) {
  using Big = boost::multiprecision::cpp_int;
  const auto to_big = [](const auto& w) {
    Big r = 0;
    constexpr int n = static_cast<int>(std::extent_v<std::remove_reference_t<decltype(w.limb)>>);
    for (int i = n; i-- > 0;) r = (r << 64) + w.limb[i];
    return w.sign() < 0 ? Big(r - (Big(1) << (64 * n))) : r;
  };
  const auto big128 = [](Int128 v) {
    const bool negative = v < 0;
    const UInt128 u = negative ? 0 - static_cast<UInt128>(v) : static_cast<UInt128>(v);
    const Big r = (Big(static_cast<std::uint64_t>(u >> 64)) << 64) + static_cast<std::uint64_t>(u);
    return negative ? Big(-r) : r;
  };
  Random random(8);
  const auto next128 = [&] {
    const std::uint64_t high = random(), low = random();
    const int shift = static_cast<int>(random.below(127));
    return static_cast<Int128>(static_cast<UInt128>(high) << 64 | low) >> shift;
  };
  for (int i = 0; i < test::repetitions(20'000); ++i) {
    const auto a = static_cast<std::int64_t>(random()) >> random.below(63);
    const Int128 b = next128(), c = next128();
    const WideInt<3> ab = multiply(a, b);
    ASSERT_EQ(to_big(ab), Big(a) * big128(b));
    const WideInt<5> abc = multiply(c, ab);
    ASSERT_EQ(to_big(abc), big128(c) * Big(a) * big128(b));
    ASSERT_EQ(abc.sign(), (big128(c) * Big(a) * big128(b)).sign());
    const WideInt<3> half = multiply(a >> 1, b);
    ASSERT_EQ(to_big(half + half), to_big(half) * 2);
    ASSERT_EQ(to_big(ab - half), to_big(ab) - to_big(half));
  }
}

TEST(BinaryScale, FitsExactlySixtyOneBits) {
  BinaryScale scale;
  EXPECT_FALSE(scale.fits()) << "nothing was added";
  scale.include(Vec3d{0x1p60, 1, 0});
  EXPECT_EQ(scale.factor(), 1.0);
  EXPECT_EQ(scale.width(), 61);
  scale.include(0.5);
  EXPECT_FALSE(scale.fits());
  EXPECT_EQ(scale.width(), 62);
  BinaryScale lattice;
  for (int k = 0; k <= 21; ++k) lattice.include(k / 21.0);
  ASSERT_TRUE(lattice.fits());
  for (int k = 0; k <= 21; ++k) {
    const double scaled = k / 21.0 * lattice.factor();
    EXPECT_EQ(scaled, std::nearbyint(scaled));
  }
}

TEST(BinaryScale, ScalesEveryIncludedDoubleExactly) {
  using Big = boost::multiprecision::cpp_int;
  const double smallest = std::numeric_limits<double>::denorm_min();
  Random random(4);
  for (int n = 0; n < test::repetitions(200); ++n) {
    std::vector<double> values{0.0, -0.0, n % 3 == 0 ? smallest : 1.0, n % 3 == 1 ? -5 * smallest : 3.0};
    for (int k = 0; k < 6; ++k)
      values.push_back((random.uniform() - 0.5) * std::ldexp(1.0, static_cast<int>(random.below(200)) - 100));
    BinaryScale scale;
    for (const double v : values) scale.include(v);
    int odd = 0;
    for (const double v : values) {
      const Big steps = scale.scaled<Big>(v);
      int exponent = 0;
      const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(v, &exponent), 53));
      const int up = exponent - 53 - scale.lowest_bit();  // v = mantissa * 2^(exponent - 53)
      EXPECT_EQ(steps << std::max(-up, 0), Big(mantissa) << std::max(up, 0)) << v;
      EXPECT_LT(abs(steps), Big(1) << scale.width());
      odd += bit_test(Big(abs(steps)), 0);
    }
    EXPECT_GT(odd, 0) << "the step is the largest possible";
  }
}

}  // namespace
}  // namespace fracture::exact
