// Vertices exactly half-way between two steps of the lattice, and extremely close to half-way. Compares the
// fast ways to place a vertex with rational arithmetic.
#include "common/clip/construction.hpp"

#include <gtest/gtest.h>

#include "common/base/random.hpp"
#include "common/clip/cut_formulas.hpp"
#include "tests/support/repetitions.hpp"

namespace fracture::clip_detail {
namespace {

float to_float(double v) { return static_cast<float>(v); }
Vec3d random_vertex(Random& random) {
  const float x = to_float(random.uniform()), y = to_float(random.uniform()), z = to_float(random.uniform());
  return {x, y, z};
}
Vec3d random_site(Random& random) {
  Vec3d p;
  for (int a = 0; a < 3; ++a) p[a] = static_cast<double>(random.below(1u << 21)) * 0x1p-21;
  return p;
}

SeamLattice lattice_of_step(int exponent) {
  SeamLattice lattice;
  lattice.exponent = {exponent, exponent, exponent};
  return lattice;
}

Fraction<Approx> approximate(const TriangleCutFormula& meet) {
  std::array<Point<Approx>, 6> p;
  for (std::size_t k = 0; k < p.size(); ++k)
    p[k] = {Approx(meet.input[k].x), Approx(meet.input[k].y), Approx(meet.input[k].z)};
  return meet(p);
}

TEST(PlacePrecisely, GivesWhatIntegersGiveOrNothing) {
  Random random(1);
  int answered = 0, level = 0;
  constexpr int kCases = 20000;
  for (int n = 0; n < kCases; ++n) {
    TriangleCutFormula meet;
    for (int k = 0; k < 3; ++k) meet.input[k] = random_site(random);
    for (int k = 3; k < 6; ++k) meet.input[k] = random_vertex(random);
    if (n % 2 == 0) {  // a face along an axis, half-way between two steps
      const double height = (static_cast<double>(random.below(1000)) + 0.5) * 0x1p-20;
      for (int k = 3; k < 6; ++k) meet.input[k][n / 2 % 3] = n % 8 == 0 ? -height : height;
      ++level;
    }
    if (n % 5 == 0) meet.input[2] = meet.input[1] + 0x1p-21 * Vec3d{1, 0, 2};  // nearly parallel planes
    if (meet.input[0] == meet.input[1] || meet.input[0] == meet.input[2]) continue;
    const SeamLattice lattice = lattice_of_step(-20);
    const Fraction<Approx> f = approximate(meet);
    if (!(std::fabs(f.denominator.value) > 1e-12)) continue;  // far away
    const Placed exact = place_exactly(meet, lattice);
    if (length(exact.point) > 100) continue;  // steps have 32 bits
    Placed placed;
    if (!place_precisely(meet, f, lattice.step(), placed)) continue;
    ++answered;
    EXPECT_EQ(placed.point, exact.point) << "case " << n;
    EXPECT_EQ(placed.steps, exact.steps) << "case " << n;
  }
  EXPECT_GT(answered, kCases * 9 / 10);
  EXPECT_GT(level, kCases / 3);
}

TEST(PlacePrecisely, LeavesToIntegersWhatLiesHalfWayByChance) {
  // The plane x = 1/2 between the sites meets the triangle's plane at y = x. So y lies half-way between two
  // steps of 1. No two corners have the same y.
  const TriangleCutFormula meet{{Vec3d{0.25, 0, 0.5}, Vec3d{0.75, 0, 0.5}, Vec3d{0.25, 0, 1.5},
                                 Vec3d{0, 0, 0}, Vec3d{1, 1, 0}, Vec3d{3, 3, 3}}};
  const SeamLattice lattice = lattice_of_step(0);
  Placed placed;
  EXPECT_FALSE(place_precisely(meet, approximate(meet), lattice.step(), placed));
  const Placed exact = place_exactly(meet, lattice);
  EXPECT_EQ(exact.point, (Vec3d{0.5, 0.5, 1}));
  EXPECT_EQ(exact.steps, (std::array<std::int32_t, 3>{0, 0, 1})) << "ties to even";
}

TEST(PlaceExactly, IntegersOfFixedAndOfAnySizeAgree) {
  Random random(2);
  for (int n = 0; n < test::repetitions(2000); ++n) {
    TriangleCutFormula meet;
    for (int k = 0; k < 3; ++k) meet.input[k] = random_site(random);
    for (int k = 3; k < 6; ++k) meet.input[k] = random_vertex(random);
    if (meet.input[0] == meet.input[1] || meet.input[0] == meet.input[2]) continue;
    BinaryScale scale;
    for (const Vec3d& p : meet.input) scale.include(p);
    const SeamLattice lattice = lattice_of_step(-23);
    if (!(std::fabs(approximate(meet).denominator.value) > 1e-12)) continue;
    const Placed fixed = place_with<exact::FixedInt>(meet, scale, lattice),
                 any = place_with<BigInt>(meet, scale, lattice);
    EXPECT_EQ(fixed.point, any.point);
    EXPECT_EQ(fixed.steps, any.steps);
  }
}

TEST(DoubleDouble, OperationsAreGoodTo100Bits) {
  using Q = boost::multiprecision::cpp_rational;
  const auto q = [](const DoubleDouble& v) { return Q(v.hi) + Q(v.lo); };
  const auto expect_close = [&](const DoubleDouble& found, const Q& exact) {
    Q off = q(found) - exact;
    if (off < 0) off = -off;
    Q size = exact < 0 ? Q(-exact) : exact;
    EXPECT_LE(off, size * Q(1, boost::multiprecision::cpp_int(1) << 100));
  };
  Random random(3);
  const auto number = [&] {
    const double hi = (random.uniform() - 0.5) * std::ldexp(1.0, static_cast<int>(random.below(40)));
    const double lo = (random.uniform() - 0.5) * std::fabs(hi) * 0x1p-53;
    return DoubleDouble::quick_sum(hi, lo);
  };
  for (int n = 0; n < test::repetitions(5000); ++n) {
    const DoubleDouble a = number(), b = n % 3 == 0 ? DoubleDouble(-a.hi, -a.lo * 0.75) : number();
    expect_close(a + b, q(a) + q(b));
    expect_close(a - b, q(a) - q(b));
    expect_close(a * b, q(a) * q(b));
    if (b.hi != 0) expect_close(a / b, q(a) / q(b));
  }
}

}  // namespace
}  // namespace fracture::clip_detail
