#include "common/base/product.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>
#include <stop_token>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

using Answer = Allowance::Answer;

TEST(Allowance, AsksOnlyWhenWhatIsGrantedIsUsedUp) {
  std::uint64_t held = 0;
  int asked = 0;
  Allowance allowance(0, 1u << 30, [&](std::uint64_t bytes) {
    ++asked;
    held = bytes;
    return Answer::kGranted;
  });
  for (int k = 0; k < 100'000; ++k) allowance.add(Product::kPolygons, 1);
  EXPECT_EQ(allowance.bytes(), 100'000 * bytes_of(Product::kPolygons));
  EXPECT_GE(held, allowance.bytes());
  EXPECT_LE(held, allowance.bytes() * 3 / 2);
  EXPECT_LE(asked, 40);  // each request is 1.5 times the one before
}

/// An import of 1.3 GB asked for 1.9 GB, and other clients could read nothing meanwhile.
TEST(Allowance, ALargeComputationAsksForLittleMoreThanItNeeds) {
  std::uint64_t held = 0;
  Allowance allowance(0, 2u << 30, [&](std::uint64_t bytes) {
    held = bytes;
    return Answer::kGranted;
  });
  allowance.add(Product::kImportBytes, 1u << 30);
  EXPECT_EQ(held, (1u << 30) + (64u << 20));
}

TEST(Allowance, TakesWhatIsNeededWhereHalfAsMuchAgainIsRefused) {
  Allowance allowance(0, 1000, [](std::uint64_t bytes) {
    return bytes <= bytes_of(Product::kSegments) ? Answer::kGranted : Answer::kNotNow;
  });
  EXPECT_NO_THROW(allowance.add(Product::kSegments, 1));
  EXPECT_THROW(allowance.add(Product::kSegments, 1), Interrupted);
}

TEST(Allowance, NamesWhatGrewBeyondWhatCanEverBeHeld) {
  constexpr std::uint64_t kLimit = 10'000;
  Allowance allowance(
      0, kLimit, [](std::uint64_t bytes) { return bytes <= kLimit ? Answer::kGranted : Answer::kNever; });
  try {
    for (int k = 0; k < 1000; ++k) allowance.add(Product::kPolygons, 1);
    FAIL() << "never refused";
  } catch (const Interrupted& interrupted) {
    ASSERT_TRUE(interrupted.error);
    EXPECT_EQ(interrupted.code, ErrorCode::kTooComplex);
    EXPECT_EQ(interrupted.error->extra->at("grew"), "polygons");
    EXPECT_EQ(interrupted.error->extra->at("limit"), kLimit);
    EXPECT_NE(interrupted.error->detail.find("fewer sites"), std::string::npos);
    EXPECT_NE(interrupted.error->detail.find("the limit for one computation is 10 kB"), std::string::npos)
        << interrupted.error->detail;
  }
}

TEST(Allowance, TellsMemoryThatOthersHoldFromWhatIsTooMuch) {
  Allowance allowance(100, 1u << 20, [](std::uint64_t) { return Answer::kNotNow; });
  try {
    allowance.add(Product::kTetrahedra, 1000);
    FAIL() << "never refused";
  } catch (const Interrupted& interrupted) {
    EXPECT_EQ(interrupted.code, ErrorCode::kOutOfMemory);
  }
}

TEST(Allowance, TellsMemoryThatTheSameClientHoldsFromMemoryOfOthers) {
  Allowance allowance(100, 1u << 20, [](std::uint64_t) { return Answer::kOverShare; });
  try {
    allowance.add(Product::kTetrahedra, 1000);
    FAIL() << "never refused";
  } catch (const Interrupted& interrupted) {
    ASSERT_TRUE(interrupted.error);
    EXPECT_EQ(interrupted.code, ErrorCode::kOverShare);
    EXPECT_GT(interrupted.error->retry_after.count(), 0);
    EXPECT_EQ(interrupted.error->detail.find("other computations are using too many"), std::string::npos);
    EXPECT_NE(interrupted.error->detail.find("1.049 MB"), std::string::npos) << "the limit";
  }
}

TEST(Allowance, ForgetsWhatWasTemporary) {
  Allowance allowance(1'000'000, 1'000'000, [](std::uint64_t) { return Answer::kNever; });
  allowance.add(Product::kSegments, 10);
  const std::uint64_t before = allowance.bytes();
  for (int pass = 0; pass < 1000; ++pass) {
    const Allowance::Temporary temporary(&allowance);
    allowance.add(Product::kSegments, 1000);
  }
  EXPECT_EQ(allowance.bytes(), before);
  EXPECT_EQ(allowance.most_bytes(), before + 1000 * bytes_of(Product::kSegments));
}

TEST(Allowance, GivesBackWhatATemporaryTookButNotWhatItBeganWith) {
  std::vector<std::uint64_t> released;
  Allowance allowance(
      100'000, 10'000'000, [](std::uint64_t) { return Answer::kGranted; },
      [&](std::uint64_t bytes) { released.push_back(bytes); });
  allowance.add(Product::kImportBytes, 150'000);
  {
    const Allowance::Temporary temporary(&allowance);
    allowance.add(Product::kImportBytes, 5'000'000);
  }
  allowance.shrink();
  allowance.shrink();
  EXPECT_EQ(released, (std::vector<std::uint64_t>{150'000})) << "once";
  Allowance unused(
      100'000, 10'000'000, [](std::uint64_t) { return Answer::kGranted; },
      [&](std::uint64_t bytes) { released.push_back(bytes); });
  unused.shrink();
  EXPECT_EQ(released.size(), 1u);
}

TEST(SortWithPolls, SortsAndCanBeInterruptedHalfWay) {
  std::vector<std::uint32_t> numbers(300'000);
  for (std::uint32_t k = 0; k < numbers.size(); ++k) numbers[k] = k * 2654435761u;
  std::vector<std::uint32_t> expected = numbers;
  std::sort(expected.begin(), expected.end());

  int polls = 0;
  Execution execution;
  execution.watch = [&] { ++polls; };
  std::vector<std::uint32_t> sorted = numbers;
  sort_with_polls(execution, sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, expected);
  EXPECT_GE(polls, 100);

  std::stop_source source;
  execution.stop = source.get_token();
  int left = polls / 2;
  execution.watch = [&] {
    if (--left == 0) source.request_stop();
  };
  EXPECT_THROW(sort_with_polls(execution, numbers.begin(), numbers.end()), Interrupted);
}

}  // namespace
}  // namespace fracture
