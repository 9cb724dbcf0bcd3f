#include "common/base/polled_search.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/support/polls.hpp"

namespace fracture {
namespace {

using namespace std::string_literals;

constexpr std::size_t kMiB = std::size_t{1} << 20;

/// Polls of a search for all places of the sequence.
int polls_of(std::string_view text, std::string_view wanted) {
  test::Polls polls;
  PolledSearch search(text, wanted, polls.execution);
  for (std::size_t at = search.find(0); at != PolledSearch::kNone; at = search.find(at + 1)) continue;
  return polls.count;
}

TEST(PolledSearch, FindsEachPlaceThatFindFinds) {
  std::mt19937 random(11);
  const auto text_of = [&random](std::size_t size, std::uint32_t letters) {
    std::string text(size, 'a');
    for (char& c : text) c = static_cast<char>('a' + random() % letters);
    return text;
  };
  for (int k = 0; k < 2000; ++k) {
    const std::uint32_t letters = 1 + static_cast<std::uint32_t>(k % 3);
    const std::string text = text_of(random() % 60, letters), wanted = text_of(1 + random() % 6, letters);
    const std::size_t from = random() % 20, end = random() % 60;
    const std::size_t there = text.find(wanted, from);
    PolledSearch search(text, wanted, kUninterrupted);
    EXPECT_EQ(search.find(from), there) << text << " " << wanted;
    EXPECT_EQ(search.find(from, end), there < end ? there : PolledSearch::kNone) << text << " " << wanted;
  }
}

TEST(PolledSearch, FindsBytesOfEachValue) {
  const std::string text = "\xff\xfe\0\x80\xff\xd8\xff\0"s;
  PolledSearch search(text, "\xff\xd8\xff", kUninterrupted);
  EXPECT_EQ(search.find(0), 4u);
  EXPECT_EQ(search.find(5), PolledSearch::kNone);
  PolledSearch longest(text, std::string_view(text).substr(1), kUninterrupted);
  EXPECT_EQ(longest.find(0), 1u);
}

TEST(PolledSearch, PollsForEachQuarterOfAMebibyteWhateverTheTextIs) {
  const std::string delimiter = "\r\n--boundary";
  for (const char flood : {'a', '\r', '\n', '-', 'b', 'y'}) {
    const int polls = polls_of(std::string(8 * kMiB, flood), delimiter);
    EXPECT_GE(polls, 32) << flood;
    EXPECT_LE(polls, 34) << flood;
  }
}

TEST(PolledSearch, DoesNotPollForEachPlace) {
  std::string places;
  for (std::size_t k = 0; k < kMiB; ++k) places += "\r\n--";
  EXPECT_GE(polls_of(places, "\r\n--"), 16);
  EXPECT_LE(polls_of(places, "\r\n--"), 18);
}

TEST(PolledSearch, IsGivenUpHalfWay) {
  const std::string text(8 * kMiB, '\r');
  test::Polls polls(5);
  PolledSearch search(text, "\r\n", polls.execution);
  EXPECT_THROW(search.find(0), Interrupted);
  EXPECT_EQ(polls.count, 5);
}

TEST(AppendWithPolls, CopiesAndPolls) {
  std::vector<std::uint8_t> bytes(2 * kMiB + 1);
  for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<std::uint8_t>(k * k >> 5);
  int polls = 0;
  Execution execution;
  execution.watch = [&polls] { ++polls; };
  std::vector<std::uint8_t> copy;
  append_with_polls<std::uint8_t>(execution, copy, bytes);
  EXPECT_TRUE(copy == bytes);
  EXPECT_EQ(polls, 9) << "eight quarters of a mebibyte, and one byte";
}

}  // namespace
}  // namespace fracture
