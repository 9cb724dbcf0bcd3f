#include "common/base/words.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "common/base/remarks.hpp"

namespace fracture {
namespace {

TEST(Words, OneThingIsNotSeveral) {
  EXPECT_EQ(counted(0, "part was", "parts were"), "0 parts were");
  EXPECT_EQ(counted(1, "part was", "parts were"), "1 part was");
  EXPECT_EQ(counted(3, "part was", "parts were"), "3 parts were");
  EXPECT_EQ(counted(4210, "triangle", "triangles"), "4,210 triangles");
}

TEST(Words, ThousandsAreGrouped) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(100'000), "100,000");
  EXPECT_EQ(grouped(std::numeric_limits<std::uint64_t>::max()), "18,446,744,073,709,551,615");
}

TEST(Words, SizesAreInPowersOfAThousand) {
  EXPECT_EQ(data_size(0), "0 bytes");
  EXPECT_EQ(data_size(1), "1 byte");
  EXPECT_EQ(data_size(999), "999 bytes");
  EXPECT_EQ(data_size(1000), "1 kB");
  EXPECT_EQ(data_size(36'700), "36.7 kB");
  EXPECT_EQ(data_size(999'960), "1 MB") << "rounded first";
  EXPECT_EQ(data_size(64u << 20), "67.11 MB");
  EXPECT_EQ(data_size(1'879'048'192), "1.879 GB");
  EXPECT_EQ(data_size(1ull << 50), "1126 TB");
}

TEST(Words, NumbersHaveFourDigitsAndNoExponentUnlessTheyAreTinyOrHuge) {
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(-0.0), "0");
  EXPECT_EQ(short_number(0.0013), "0.0013");
  EXPECT_EQ(short_number(0.0001), "0.0001");
  EXPECT_EQ(short_number(1.0 / 3), "0.3333");
  EXPECT_EQ(short_number(-2.5), "-2.5");
  EXPECT_EQ(short_number(9999), "9999");
  EXPECT_EQ(short_number(9999.6), "10,000") << "rounded first";
  EXPECT_EQ(short_number(12'345), "12,340") << "as printf rounds halves: to even";
  EXPECT_EQ(short_number(-1'234'567), "-1,235,000");
  EXPECT_EQ(short_number(999'900'000), "999,900,000");
  EXPECT_EQ(short_number(1e9), "1e+09");
  EXPECT_EQ(short_number(1.234'56e-7), "1.235e-07");
  EXPECT_EQ(short_number(std::numeric_limits<double>::infinity()), "inf");
}

TEST(Remarks, ASentenceIsOnceInItsListInTheOrderOfFirstAppearance) {
  Remarks remarks;
  EXPECT_TRUE(remarks.empty());
  remarks.warn("b");
  remarks.note("c");
  remarks.warn("a");
  remarks.warn("b");
  remarks.note("c");
  EXPECT_EQ(remarks, (Remarks{{"b", "a"}, {"c"}}));
  remarks.add({{"a", "d"}, {"c", "e"}});
  EXPECT_EQ(remarks, (Remarks{{"b", "a", "d"}, {"c", "e"}}));
  EXPECT_FALSE(remarks.empty());
}

// Each sentence is compared with all others, and files can cause as many as they have names.
TEST(Remarks, ListsAreLimited) {
  Remarks remarks;
  for (int k = 0; k < 1200; ++k) remarks.warn(std::to_string(k));
  ASSERT_EQ(remarks.warnings.size(), 1001u);
  EXPECT_EQ(remarks.warnings[999], "999");
  EXPECT_NE(remarks.warnings[1000].find("not listed"), std::string::npos);
}

}  // namespace
}  // namespace fracture
