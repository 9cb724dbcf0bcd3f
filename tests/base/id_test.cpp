#include "common/base/id.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

namespace fracture {
namespace {

using AppleId = Id<struct AppleTag>;
using PearId = Id<struct PearTag>;

template <class A, class B>
concept Equated = requires(A a, B b) {
  a == b;
};
template <class A, class B>
concept Differing = requires(A a, B b) {
  a != b;
};
template <class A, class B>
concept Ordered = requires(A a, B b) {
  a < b;
};
template <class To, class From>
concept Cast = requires(From from) {
  static_cast<To>(from);
};

// Allowed: comparing ids of one kind with each other and with numbers, and converting an id to a number.
static_assert(Equated<AppleId, AppleId> && Differing<AppleId, AppleId> && Ordered<AppleId, AppleId>);
static_assert(Equated<AppleId, std::uint32_t> && Ordered<AppleId, std::uint32_t> &&
              Ordered<std::size_t, AppleId>);
static_assert(std::is_convertible_v<AppleId, std::uint32_t> && std::is_convertible_v<AppleId, std::size_t>);
static_assert(Cast<AppleId, std::uint32_t> && Cast<AppleId, std::size_t> && Cast<AppleId, std::ptrdiff_t>);

// Does not compile: mixing two kinds of ids, or converting a number to an id implicitly.
static_assert(!Equated<AppleId, PearId> && !Differing<AppleId, PearId> && !Ordered<AppleId, PearId>);
static_assert(!Cast<AppleId, PearId> && !std::is_constructible_v<AppleId, PearId>);
static_assert(!std::is_assignable_v<AppleId&, PearId> && !std::is_assignable_v<AppleId&, std::uint32_t>);
static_assert(!std::is_convertible_v<PearId, AppleId> && !std::is_convertible_v<std::uint32_t, AppleId>);
static_assert(!std::is_constructible_v<AppleId, double>);

// Ids cost nothing compared with plain numbers.
static_assert(sizeof(std::array<AppleId, 3>) == 12 && std::is_trivially_copyable_v<AppleId> &&
              std::is_trivially_default_constructible_v<AppleId>);

TEST(Id, CountsComparesAndHashesAsItsNumber) {
  AppleId apple{41};
  EXPECT_EQ(apple++, AppleId{41});
  EXPECT_EQ(++apple, AppleId{43u});
  EXPECT_EQ(apple, 43u);
  EXPECT_LT(apple, AppleId{std::size_t{44}});
  EXPECT_EQ(AppleId{}, AppleId{0});
  std::vector<AppleId> apples{AppleId{7}, AppleId{2}, AppleId{7}};
  std::sort(apples.begin(), apples.end());
  EXPECT_EQ(apples, (std::vector<AppleId>{AppleId{2}, AppleId{7}, AppleId{7}}));
  EXPECT_EQ(std::unordered_set<AppleId>(apples.begin(), apples.end()).size(), 2u);
}

TEST(Id, IndexesAndPrintsByItself) {
  const std::vector<int> weights{10, 20, 30};
  const int list[] = {1, 2, 3};
  const AppleId apple{2};
  EXPECT_EQ(weights[apple], 30);
  EXPECT_EQ(list[apple], 3);
  EXPECT_EQ(std::to_string(apple), "2");
  std::ostringstream text;
  text << apple;
  EXPECT_EQ(text.str(), "2");
}

TEST(Id, RangesVisitEachIdOnceInOrder) {
  std::vector<AppleId> seen;
  for (const AppleId apple : ids<AppleId>(3)) seen.push_back(apple);
  for (const AppleId apple : ids<AppleId>(7, 9)) seen.push_back(apple);
  for (const AppleId apple : ids<AppleId>(0)) seen.push_back(apple);
  for (const AppleId apple : ids<AppleId>(5, 5)) seen.push_back(apple);
  EXPECT_EQ(seen, (std::vector<AppleId>{AppleId{0}, AppleId{1}, AppleId{2}, AppleId{7}, AppleId{8}}));
}

}  // namespace
}  // namespace fracture
