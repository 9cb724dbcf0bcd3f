#include "common/base/nearest_name.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace fracture {
namespace {

const std::vector<std::string> kNames{"seed", "unit", "lid", "lip", "lie", "lit", "sites"};

TEST(NearestName, ASuggestionIsNear) {
  EXPECT_EQ(did_you_mean("sed", kNames), " Did you mean 'seed'?");
  EXPECT_EQ(did_you_mean("sties", kNames), " Did you mean 'sites'?") << "two letters are swapped";
  EXPECT_EQ(did_you_mean("xyzzy", kNames), "");
  EXPECT_EQ(did_you_mean("", kNames), "");
  EXPECT_EQ(did_you_mean("seed", {}), "");
  EXPECT_EQ(did_you_mean(std::string(1000, 'a'), kNames), "");
}

TEST(NearestName, AtMostThreeOfTheNearestAreSuggested) {
  EXPECT_EQ(did_you_mean("lix", kNames), " Did you mean 'lid', 'lip' or 'lie'?");
  EXPECT_EQ(did_you_mean("lit", kNames), " Did you mean 'lit'?") << "the others are farther";
  const std::vector<std::string> two{"lid", "lip", "lip"};
  EXPECT_EQ(did_you_mean("lix", two), " Did you mean 'lid' or 'lip'?") << "each name once";
}

}  // namespace
}  // namespace fracture
