// Parameters as text: of requests and of stored parameters. One reader with limits reads both.
#include "common/parameters/parameter_object.hpp"

#include <gmock/gmock.h>

#include <string>

namespace fracture {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string repeated(std::string_view text, std::size_t times) {
  std::string all;
  for (std::size_t k = 0; k < times; ++k) all += text;
  return all;
}

TEST(ParameterObject, OfARequestIsOneObjectWithinLimits) {
  const auto read = read_parameters(R"({"sites": 5, "seed": 7})", "body");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].name, "sites") << "in the order of the text";
  EXPECT_FALSE((*read)[0].is_text);
  for (const std::string& bad : {std::string("[]"), std::string("{"), std::string("5"),
                                 "{\"x\":" + repeated("[", 9) + repeated("]", 9) + "}",
                                 "{\"x\":\"" + std::string(kOfRequest.text, ' ') + "\"}",
                                 "{\"x\":[" + repeated("{},", 100'000) + "{}]}"}) {
    const auto refused = read_parameters(bad, "part 'params'");
    ASSERT_FALSE(refused) << bad.substr(0, 40);
    EXPECT_EQ(refused.error().code, ErrorCode::kBadJson);
    EXPECT_THAT(refused.error().detail, HasSubstr("part 'params'"));
  }
  const auto twice = read_parameters(R"({"sites": 5, "sites": 6})", "body");
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(twice.error().pointer, "sites");
}

TEST(ParameterObject, KeptParametersComeInTheirCanonicalForm) {
  const auto kept =
      read_kept_parameters(R"({"local_point": [0.5, 0.5, 0.5], "local_radius": 0.2, "sites": 9})");
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->at("sites"), 9);
  EXPECT_EQ(kept->at("local_point"), json::parse("[[0.5, 0.5, 0.5]]"));
  EXPECT_EQ(kept->at("local_radius"), json::parse("[0.2]"));
  EXPECT_EQ(read_kept_parameters(kept->dump()), kept);
}

TEST(ParameterObject, WhatNoRequestCouldHaveHadWasNotKept) {
  for (const std::string& forged :
       {std::string(), std::string("[]"), std::string("{"), std::string(R"({"sites": "x"})"),
        std::string(R"({"sites": 4000000000})"), std::string(R"({"stretch": 1e999})"),
        std::string(R"({"local_point": 5})"), std::string(R"({"no_such_parameter": 1})"),
        R"({"exterior": "material", "of": "sha256:)" + std::string(64, 'a') + "\"}",
        std::string("{\"material\": \"\xff\xff\"}"),
        "{\"sites\": 5, \"x\": " + repeated("[", 200'000) + repeated("]", 200'000) + "}",
        "{\"sites\": 5, \"x\": " + repeated("{\"a\":", 200'000) + "1" + repeated("}", 200'000) + "}",
        "{\"points\": [" + repeated("0,", 3'000'000) + "0]}"})
    EXPECT_FALSE(read_kept_parameters(forged)) << forged.substr(0, 40);
  EXPECT_FALSE(are_parameters(json(5)));
  EXPECT_TRUE(are_parameters(json::object()));
}

/// The limits of requests and of stored parameters must agree: a number that is short in a request is long
/// when stored.
TEST(ParameterObject, WhatARequestMayHaveCanBeKept) {
  std::string text = R"({"pattern": "points", "points": [)";
  while (text.size() < 900'000) text += "[9e5,1e5,8e5],";  // their memory is just below kOfRequest.held
  text += "[0,0,0]]}";
  const auto given = read_parameters(text, "body");
  ASSERT_TRUE(given) << given.error().detail;
  const auto parsed = ParameterTable(kMostSitesAnywhere, FormatSet::all()).parse(*given);
  ASSERT_TRUE(parsed) << parsed.error().detail;
  const json canonical = canonical_parameters(*parsed);
  EXPECT_EQ(read_kept_parameters(canonical.dump()), canonical);
}

}  // namespace
}  // namespace fracture
