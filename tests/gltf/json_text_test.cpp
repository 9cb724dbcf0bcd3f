// Figures as text: the shortest text that reads back as the same number.
#include "common/gltf/json_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace fracture {
namespace {

std::string rounded(double number) {
  JsonText text;
  text.rounded(number);
  return text.take();
}

TEST(JsonText, WhatIsRoundedReadsBackAsTheNearestFloat) {
  for (const double number :
       {1.0 / 3, -2.0 / 3, 1e-30, 16'777'217.0, 0.1, 12'345.678, -1e38,
        double{std::numeric_limits<float>::max()}, double{std::numeric_limits<float>::denorm_min()}}) {
    const std::string text = rounded(number);
    EXPECT_EQ(nlohmann::json::parse(text).get<float>(), static_cast<float>(number)) << text;
    EXPECT_LE(text.size(), 16u) << text << ": a float has nine digits";
  }
  EXPECT_EQ(rounded(0.1), "0.1");
}

TEST(JsonText, WhatNoFloatHoldsStaysADouble) {
  for (const double number : {1e39, -1e300, 1e-50, -1e-300})
    EXPECT_EQ(nlohmann::json::parse(rounded(number)).get<double>(), number);
}

TEST(JsonText, ZeroKeepsItsSignAndNoReaderTakesItForAnInteger) {
  EXPECT_EQ(nlohmann::json::parse(rounded(0.0)).get<double>(), 0);
  const auto read = nlohmann::json::parse(rounded(-0.0));
  EXPECT_TRUE(read.is_number_float()) << read;
  EXPECT_TRUE(std::signbit(read.get<double>())) << read;
}

TEST(JsonText, WhatIsNoNumberIsNotWritten) {
  EXPECT_THROW(rounded(std::nan("")), InternalError);
  EXPECT_THROW(rounded(-std::numeric_limits<double>::infinity()), InternalError);
}

}  // namespace
}  // namespace fracture
