// Numbers that are read in one pass: the same values as std::from_chars, and nothing that it would read differently.
#include "common/import/obj_scan.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <string>

#include "common/base/random.hpp"

namespace fracture::test {
namespace {

/// The number of bytes that scan_number() goes past; 0 if it refuses the text.
std::size_t scanned(const std::string& text, double& number) {
  const char* at = text.data();
  return scan_number(at, text.data() + text.size(), number) ? static_cast<std::size_t>(at - text.data()) : 0;
}

TEST(ObjScan, NumbersAreTheNearestDoubles) {
  constexpr std::uint64_t kSeed = 20260101;
  Random random(kSeed);
  std::size_t read = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string text = random.below(2) == 0 ? "" : "-";
    for (std::uint64_t k = random.below(12); k > 0; --k) text += static_cast<char>('0' + random.below(10));
    if (random.below(4) != 0) text += '.';
    for (std::uint64_t k = random.below(12); k > 0; --k) text += static_cast<char>('0' + random.below(10));
    double number = 0;
    const std::size_t size = scanned(text + " 7", number);
    if (size == 0) continue;
    ++read;
    ASSERT_EQ(size, text.size()) << text;
    double right = 0;
    std::from_chars(text.data(), text.data() + text.size(), right);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(number), std::bit_cast<std::uint64_t>(right)) << text;
  }
  EXPECT_GT(read, 10'000u);
}

TEST(ObjScan, OtherTextIsLeftToTheGeneralParser) {
  double number = 0;
  for (const char* text : {"", "-", ".", "-.", "+1", "--1", "1e2", "1x", "1,5", "nan", "1#",
                           "1234567890123456789", "9007199254740993"})
    EXPECT_EQ(scanned(text, number), 0u) << text;
  EXPECT_EQ(scanned("-0", number), 2u);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(number), std::bit_cast<std::uint64_t>(-0.0));
  EXPECT_EQ(scanned("12.5\t3", number), 4u);
  EXPECT_EQ(number, 12.5);
}

TEST(ObjScan, IndicesHaveAtMostNineDigits) {
  const auto scan = [](const std::string& text) {
    const char* at = text.data();
    std::int64_t number = -1;
    return scan_index(at, text.data() + text.size(), number) ? number : -1;
  };
  EXPECT_EQ(scan("7/8"), 7);
  EXPECT_EQ(scan("999999999"), 999'999'999);
  EXPECT_EQ(scan("0012 "), 12);
  for (const char* text : {"", "-1", "+1", "/1", "1234567890"}) EXPECT_EQ(scan(text), -1) << text;
}

}  // namespace
}  // namespace fracture::test
