#include "common/base/error.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace fracture {
namespace {

constexpr ErrorCode kAll[] = {
#define FRACTURE_ERROR(name, slug, title) ErrorCode::name,
#define FRACTURE_LOCAL_ERROR FRACTURE_ERROR
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
};

TEST(ErrorCodes, EveryCodeHasASlugOfItsOwnInKebabCaseAndATitle) {
  std::set<std::string> slugs;
  for (const ErrorCode code : kAll) {
    const std::string s = slug(code);
    EXPECT_TRUE(slugs.insert(s).second) << s;
    EXPECT_EQ(s.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string::npos) << s;
    EXPECT_FALSE(std::string(title(code)).empty()) << s;
  }
}

TEST(ErrorCodes, AreFoundByTheSlugsThatServersSay) {
#define FRACTURE_ERROR(name, its_slug, title) EXPECT_EQ(error_code(its_slug), ErrorCode::name);
#include "common/base/error_codes.def"
#undef FRACTURE_ERROR
  EXPECT_EQ(error_code(slug(ErrorCode::kFileAccess)), std::nullopt) << "of this machine alone";
  EXPECT_EQ(error_code(""), std::nullopt);
}

TEST(Expected, CarriesTheErrorWithItsFigures) {
  const Expected<int> refused = fail(ErrorCode::kTooLarge, "Too many.", "sites", {{"limit", 3}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(refused.error().pointer, "sites");
  EXPECT_EQ(refused.error().extra->at("limit"), 3);
  EXPECT_EQ(to_string(refused.error()), "too-large: Too many.");
}

}  // namespace
}  // namespace fracture
