// Numbers and lines of text files.
#include "common/import/text_scanner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/import/refused.hpp"

namespace fracture::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

double scanned(std::string_view word) { return TextScanner(word, "TXT", true).number("a number"); }

std::string refusal_of(std::string_view word) {
  try {
    const double value = scanned(word);
    return "read as " + std::to_string(value);
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.error.code, ErrorCode::kMalformedMesh);
    return refused.error.detail;
  }
}

TEST(TextScanner, ReadsNumbersAsAllProgramsWriteThem) {
  EXPECT_EQ(scanned("1"), 1);
  EXPECT_EQ(scanned("+2.5"), 2.5);
  EXPECT_EQ(scanned("-.5"), -0.5);
  EXPECT_EQ(scanned("5."), 5);
  EXPECT_EQ(scanned("1e2"), 100);
  EXPECT_EQ(scanned("25E-2#comment"), 0.25);
  EXPECT_EQ(scanned("5. #comment"), 5);
  EXPECT_TRUE(std::signbit(scanned("-0")));
  EXPECT_EQ(scanned("0.1"), 0.1) << "rounded to the nearest double";
  EXPECT_EQ(static_cast<float>(scanned("16777217.1")), 16777218.0f);
}

TEST(TextScanner, NumbersOutsideTheRangeAreInfiniteOrZero) {
  EXPECT_EQ(scanned("1e999"), HUGE_VAL);
  EXPECT_EQ(scanned("-1e999"), -HUGE_VAL);
  EXPECT_EQ(scanned("1" + std::string(400, '0')), HUGE_VAL);
  EXPECT_EQ(scanned("1e-999"), 0);
  EXPECT_EQ(scanned("0." + std::string(400, '0') + "1"), 0);
  EXPECT_EQ(scanned("0e999"), 0);
}

TEST(TextScanner, EverySpellingOfNotANumberIsNan) {
  for (const char* word : {"nan", "NaN", "-nan", "-nan(ind)", "nan(0x1)", "-1.#IND", "1.#QNAN00", "1.#SNAN"})
    EXPECT_TRUE(std::isnan(scanned(word))) << word;
  for (const char* word : {"inf", "-inf", "Infinity", "1.#INF"})
    EXPECT_FALSE(std::isfinite(scanned(word))) << word;
}

TEST(TextScanner, OtherWordsAreRefusedWithTheLine) {
  for (const char* word : {"1,5", "abc", "--1", "+-1", "0x10", "1.2.3", "1e", "-", "12abc"})
    EXPECT_THAT(refusal_of(word),
                AllOf(HasSubstr("a number at line 1"), HasSubstr(std::string("\"") + word + "\"")));
  EXPECT_THAT(refusal_of("\n\r\n\rx\xff"), AllOf(HasSubstr("line 4"), HasSubstr("\"x\xc3\xbf\"")));
  EXPECT_THAT(refusal_of("# only a comment\n"), AllOf(HasSubstr("ends at line 2"), HasSubstr("cut short")));
}

TEST(TextScanner, LinesEndWithAnyOfTheThree) {
  const std::string text = "a b\nc\r\nd\re";
  TextScanner scan(text, "TXT", false);
  EXPECT_EQ(scan.word_in_line(), "a");
  EXPECT_EQ(scan.word_in_line(), "b");
  EXPECT_EQ(scan.word_in_line(), "");
  for (const auto& [word, line] :
       {std::pair{"c", "line 2"}, std::pair{"d", "line 3"}, std::pair{"e", "line 4"}}) {
    ASSERT_TRUE(scan.find_word());
    EXPECT_EQ(scan.place(scan.at()), line);
    EXPECT_EQ(scan.word_in_line(), word);
  }
  EXPECT_FALSE(scan.find_word());
  EXPECT_EQ((FilePlaces{text, false}(7)), "byte 7");
}

TEST(TextScanner, CountsAreWholeNumbers) {
  EXPECT_EQ(TextScanner("18446744073709551615", "TXT", false).count("a count"), 18446744073709551615u);
  for (const char* word : {"-1", "1.0", "18446744073709551616", "x"})
    EXPECT_THROW(TextScanner(word, "TXT", false).count("a count"), Refused) << word;
}

}  // namespace
}  // namespace fracture::test
