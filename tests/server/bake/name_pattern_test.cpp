// Name patterns match as POSIX fnmatch() does, for every byte, and within a time limit.
#include "common/base/name_pattern.hpp"

#include <fnmatch.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/support/full_tests.hpp"

namespace fracture::bake {
namespace {

bool matches(std::string_view pattern, std::string_view text) {
  MatchBudget budget(1'000'000, {});
  return matches_pattern(pattern, text, budget);
}

TEST(NamePatterns, AreThoseOfFnmatch) {
  std::mt19937 random(7);
  const auto text_of = [&](std::string_view letters, std::size_t most) {
    std::string text;
    for (std::size_t n = random() % (most + 1); n > 0; --n) text += letters[random() % letters.size()];
    return text;
  };
  std::size_t fits = 0;
  for (int k = 0; k < test::sized(30'000, 300'000); ++k) {
    const std::string pattern = text_of("aab*?[]!-\\c/.", 9), text = text_of("aab-c/.]\\[", 7);
    const bool expected = ::fnmatch(pattern.c_str(), text.c_str(), 0) == 0;
    fits += expected;
    // glibc and POSIX differ about collating symbols, equivalence classes and unclosed items in a bracket
    // expression.
    if (pattern.find("[.") != std::string::npos || pattern.find("[[") != std::string::npos) continue;
    ASSERT_EQ(matches(pattern, text), expected) << "'" << pattern << "' and '" << text << "'";
  }
  EXPECT_GT(fits, test::sized(100u, 1000u)) << "the comparison is of something";
}

TEST(NamePatterns, KnowClassesOfCharacters) {
  for (const char* pattern :
       {"[[:digit:]]", "[![:alpha:]]", "[[:digit:]a-c]", "[[:upper:][:lower:]]", "[^[:space:]]"})
    for (int c = 1; c < 128; ++c) {
      const std::string text(1, static_cast<char>(c));
      ASSERT_EQ(matches(pattern, text), ::fnmatch(pattern, text.c_str(), 0) == 0) << pattern << " and " << c;
    }
}

TEST(NamePatterns, CompareWhatIsBehindANulToo) {
  EXPECT_FALSE(matches("lid", std::string_view("lid\0x", 5)));
  EXPECT_TRUE(matches("lid*x", std::string_view("lid\0x", 5)));
  EXPECT_TRUE(matches("lid??", std::string_view("lid\0x", 5)));
}

TEST(NamePatterns, EndWithTheBudgetOrTheStop) {
  const std::string text(100'000, 'a');
  MatchBudget budget(1'000'000, {});
  EXPECT_FALSE(matches_pattern("*a*a*" + std::string(900, 'a') + "b", text, budget));
  EXPECT_TRUE(budget.spent());
  EXPECT_FALSE(matches_pattern("*", "a", budget)) << "nothing is left";
  std::stop_source stop;
  stop.request_stop();
  MatchBudget stopped(1'000'000'000, stop.get_token());
  EXPECT_FALSE(matches_pattern("*a*a*" + std::string(900, 'a') + "b", text, stopped));
  EXPECT_TRUE(stopped.stopped());
}

}  // namespace
}  // namespace fracture::bake
