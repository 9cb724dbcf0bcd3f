// make_solid() over families of growing meshes. It can be interrupted at any time, and its work is
// near-linear.
#include <gtest/gtest.h>

#include <stop_token>

#include "common/base/product.hpp"
#include "common/solid/solid.hpp"
#include "tests/solid/families.hpp"
#include "tests/support/poll_gaps.hpp"
#include "tests/support/shapes.hpp"

namespace fracture::test {
namespace {

#if defined(FRACTURE_SANITIZED) || !defined(NDEBUG)
constexpr int kShare = 10;
#else
constexpr int kShare = 1;
#endif

Polled effort_of(const GrowingFamily& family, int size) {
  const auto mesh = std::make_shared<const Mesh>(family.mesh(size));
  return polled([&](const Execution& execution) {
    const Expected<Solid> solid = make_solid(mesh, family.options, execution);
  });
}

class Growth : public testing::TestWithParam<GrowingFamily> {};
INSTANTIATE_TEST_SUITE_P(Solid, Growth, testing::ValuesIn(growing_families()), [](const auto& family) {
  std::string name = family.param.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

TEST_P(Growth, AnInterruptionTakesEffectWithinFiftyMillisecondsOfProcessorTime) {
  EXPECT_LT(effort_of(GetParam(), GetParam().size / kShare).longest_ms, kMostPollGapMs);
}

TEST_P(Growth, FourTimesTheTrianglesAreAboutFourTimesTheWork) {
  const int size = GetParam().size / kShare;
  const Polled few = effort_of(GetParam(), size / 4), many = effort_of(GetParam(), size);
  EXPECT_GT(many.polls, static_cast<std::uint64_t>(size) / 8192) << "work is polled";
  EXPECT_LT(many.polls, 6 * few.polls + 100);
}

TEST_P(Growth, StopsAtWhicheverPollItIsAskedTo) {
  const auto mesh = std::make_shared<const Mesh>(GetParam().mesh(3000));
  const std::uint64_t polls = effort_of(GetParam(), 3000).polls;
  ASSERT_GT(polls, 5u);
  for (std::uint64_t at = 0; at < polls; at += 1 + polls / 20) {
    std::stop_source source;
    std::uint64_t seen = 0;
    Execution execution;
    execution.stop = source.get_token();
    execution.watch = [&] {
      if (seen++ == at) source.request_stop();
    };
    EXPECT_THROW((void)make_solid(mesh, GetParam().options, execution), Interrupted) << "poll " << at;
    EXPECT_EQ(seen, at + 1);
  }
}

// -- counting of products

/// The bytes that make_solid() reports, or the reason for its refusal.
std::uint64_t bytes_made(const Mesh& mesh, const SolidOptions& options, std::uint64_t limit) {
  Allowance allowance(0, limit, [limit](std::uint64_t bytes) {
    return bytes <= limit ? Allowance::Answer::kGranted : Allowance::Answer::kNever;
  });
  Execution execution;
  execution.allowance = &allowance;
  EXPECT_TRUE(make_solid(std::make_shared<const Mesh>(mesh), options, execution));
  return allowance.bytes();
}

TEST(Products, TheFillOfHolesIsCounted) {
  const std::uint64_t each = bytes_of(Product::kSurfaceTriangles);
  EXPECT_EQ(bytes_made(cube(3), {}, 1 << 20), 0u);
  EXPECT_EQ(bytes_made(cube_without({1}), {}, 1 << 20), 2 * each);
  EXPECT_EQ(bytes_made(cube_without({0, 1}), {}, 1 << 20), 4 * each);
}

TEST(Products, BacksAndWallsOfSlabsAreCounted) {
  // Two triangles close the quad's two. They are then replaced by a back of 2 triangles and walls of 8.
  EXPECT_EQ(bytes_made(open_quad(), {.thickness = 0.25}, 1 << 20), 12 * bytes_of(Product::kSurfaceTriangles));
}

TEST(Products, AFillThatNeverFitsIsTooComplex) {
  Allowance allowance(0, 300, [](std::uint64_t) { return Allowance::Answer::kNever; });
  Execution execution;
  execution.allowance = &allowance;
  try {
    (void)make_solid(std::make_shared<const Mesh>(cube_without({1})), {}, execution);
    FAIL() << "not interrupted";
  } catch (const Interrupted& interrupted) {
    EXPECT_EQ(interrupted.code, ErrorCode::kTooComplex);
  }
}

}  // namespace
}  // namespace fracture::test
