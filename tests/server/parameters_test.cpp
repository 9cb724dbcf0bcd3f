#include "server/service/parameters.hpp"

#include <gtest/gtest.h>

namespace fracture {
namespace {

const ParameterTable& table() {
  static const ParameterTable instance(100'000, FormatSet());
  return instance;
}

Expected<RequestParameters> parse_text(const std::string& name, const std::string& value) {
  return table().parse({{name, value, true}});
}

TEST(Parameters, NothingGivenMeansTheDefaults) {
  const auto parsed = table().parse({});
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->fracture.sites, 50u);
  EXPECT_EQ(parsed->fracture.seed, 1u);
  EXPECT_EQ(parsed->fracture.dual, Dual::kCircumcenter);
  EXPECT_FALSE(parsed->format);
}

TEST(Parameters, BothEndsOfEachRangeAreAccepted) {
  EXPECT_EQ(parse_text("sites", "1")->fracture.sites, 1u);
  EXPECT_EQ(parse_text("sites", "100000")->fracture.sites, 100'000u);
  EXPECT_EQ(parse_text("seed", "0")->fracture.seed, 0u);
  EXPECT_EQ(parse_text("seed", "9007199254740991")->fracture.seed, 9007199254740991u);
  EXPECT_EQ(parse_text("dual", "barycenter")->fracture.dual, Dual::kBarycenter);
}

TEST(Parameters, EverythingThatIsNoNumberInRangeIsRefusedWithValueAndRange) {
  for (const char* bad : {"0", "-5", "1e12", "1000000000000", "100001", "", " 5", "5 ", "+5", "0x10", "5.0",
                          "nan", "99999999999999999999999999"}) {
    const auto parsed = parse_text("sites", bad);
    ASSERT_FALSE(parsed) << bad;
    EXPECT_EQ(parsed.error().code, ErrorCode::kBadParameter) << bad;
    EXPECT_EQ(parsed.error().pointer, "sites") << bad;
    EXPECT_NE(parsed.error().detail.find("from 1 to 100000"), std::string::npos) << parsed.error().detail;
    EXPECT_NE(parsed.error().detail.find(std::string("'") + bad + "'"), std::string::npos)
        << parsed.error().detail;
  }
}

TEST(Parameters, AnUnknownNameIsRefusedByNameWithTheKnownOnes) {
  const auto parsed = parse_text("site", "5");
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().code, ErrorCode::kUnknownParameter);
  EXPECT_EQ(parsed.error().pointer, "site");
  EXPECT_NE(parsed.error().detail.find("sites"), std::string::npos);
}

TEST(Parameters, EveryOffenderIsListed) {
  const auto parsed = table().parse({{"sites", "0"}, {"colour", "red"}, {"dual", 5, false}});
  ASSERT_FALSE(parsed);
  const auto& errors = parsed.error().extra.at("errors");
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_EQ(errors[0].at("parameter"), "sites");
  EXPECT_EQ(errors[1].at("parameter"), "colour");
  EXPECT_EQ(errors[2].at("pointer"), "/dual");
}

TEST(Parameters, GivenTwiceIsRefusedEvenWithTheSameValue) {
  const auto parsed = table().parse({{"sites", "5"}, {"sites", 5, false}});
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().code, ErrorCode::kBadParameter);
}

TEST(Parameters, JsonValuesMustHaveTheirOwnType) {
  EXPECT_EQ(table().parse({{"sites", 7, false}})->fracture.sites, 7u);
  const std::vector<nlohmann::json> wrong = {nlohmann::json("7"),        nlohmann::json(7.0),
                                             nlohmann::json(true),       nlohmann::json(-7),
                                             nlohmann::json::array({7}), nlohmann::json()};
  for (const nlohmann::json& value : wrong) EXPECT_FALSE(table().parse({{"sites", value, false}})) << value;
}

TEST(Parameters, FormatsThatAreOffAreUnknownUntilEnabled) {
  EXPECT_EQ(parse_text("format", "blend").error().code, ErrorCode::kUnknownFormat);
  EXPECT_EQ(parse_text("format", "exe").error().code, ErrorCode::kUnknownFormat);
  EXPECT_EQ(parse_text("format", "obj")->format, MeshFormat::kObj);
  EXPECT_EQ(parse_text("format", "STL")->format, MeshFormat::kStl);
  FormatSet with_blend;
  with_blend.enable(MeshFormat::kBlend);
  EXPECT_EQ(ParameterTable(10, with_blend).parse({{"format", "blend"}})->format, MeshFormat::kBlend);
}

TEST(Parameters, ControlCharactersOfTheClientNeverReachTheDetail) {
  const auto parsed = parse_text("sites", std::string("a\r\n\x1b[31m\xff", 9));
  ASSERT_FALSE(parsed);
  for (const char c : parsed.error().detail) EXPECT_TRUE(c >= 0x20 && c < 0x7f);
}

TEST(Parameters, OneSpellingForEveryWayToAsk) {
  const auto by_text = table().parse({{"seed", "3"}, {"sites", "50"}});
  const auto by_json = table().parse({{"seed", 3, false}});
  EXPECT_EQ(canonical_parameters(by_text->fracture).dump(), canonical_parameters(by_json->fracture).dump());
  EXPECT_EQ(canonical_parameters(by_text->fracture).dump(), R"({"dual":"circumcenter","seed":3,"sites":50})");
}

}  // namespace
}  // namespace fracture
