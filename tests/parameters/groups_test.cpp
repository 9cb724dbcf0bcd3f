// Groups and synonyms of parameters, and what a wrong name or value probably means.
#include "common/parameters/groups.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tests/parameters/parse.hpp"

namespace fracture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const ParameterSpec& spec : table().specs()) names.push_back(spec.name);
  return names;
}

TEST(ParameterGroups, EveryParameterIsInExactlyOneGroup) {
  std::map<std::string, int> listed;
  std::set<std::string_view> titles;
  for (const ParameterGroup& group : parameter_groups()) {
    EXPECT_TRUE(titles.insert(group.title).second) << group.title << " occurs twice";
    EXPECT_FALSE(group.parameters.empty()) << group.title;
    for (const GroupedParameter& row : group.parameters) ++listed[std::string(row.name)];
  }
  for (const std::string& name : names()) EXPECT_EQ(listed[name], 1) << name;
  EXPECT_EQ(listed.size(), names().size()) << "a group lists a name that is not a parameter";
}

TEST(ParameterGroups, NoSynonymIsTheNameOfAParameter) {
  const std::vector<std::string> all = names();
  for (const std::string& name : all)
    for (const std::string& word : synonyms_of(name))
      EXPECT_EQ(std::count(all.begin(), all.end(), word), 0) << word << " of " << name;
}

TEST(ParameterGroups, AreInTheListForClientsWithTheSynonyms) {
  const nlohmann::json groups = parameter_groups_json();
  ASSERT_EQ(groups.size(), parameter_groups().size());
  EXPECT_EQ(groups[0]["title"], "The mesh");
  EXPECT_EQ(groups[0]["parameters"][0], "format");
  for (const nlohmann::json& parameter : table().to_json())
    if (parameter["name"] == "fragments") {
      EXPECT_THAT(parameter["synonyms"].get<std::vector<std::string>>(), testing::Contains("pieces"));
    }
}

TEST(ParameterGroups, AWrongNameMeansTheParameterWithThisSynonymOrTheNearest) {
  const std::vector<std::string> all = names();
  const std::pair<const char*, const char*> cases[] = {
      {"pieces", "fragments"},   {"Number-Of-Pieces", "fragments"}, {"hit_radius", "local_radius"},
      {"bounce", "restitution"}, {"materal", "material"},           {"fragmets", "fragments"}};
  for (const auto& [given, meant] : cases) EXPECT_EQ(parameter_meant_by(given, all), meant) << given;
  EXPECT_EQ(parameter_meant_by("xyzzyxyzzy", all), std::nullopt);
  const std::vector<std::string> few{"sites"};
  EXPECT_EQ(parameter_meant_by("pieces", few), std::nullopt) << "only known names are suggested";
}

TEST(ParameterGroups, AnUnknownNameIsAnsweredWithTheParameterWithThisSynonym) {
  const auto parsed = parse_text("pieces", "30");
  ASSERT_FALSE(parsed);
  EXPECT_THAT(
      parsed.error().detail,
      AllOf(HasSubstr("'pieces' is not a parameter. Did you mean 'fragments'?"), HasSubstr("bake --help")));
}

TEST(ParameterGroups, AnUnknownNameIsAnsweredWithNearNamesOnly) {
  const std::string sed = parse_text("sed", "1").error().detail;
  EXPECT_THAT(sed, AllOf(HasSubstr("Did you mean 'seed'?"), Not(HasSubstr("gravity"))));
  EXPECT_THAT(parse_text("xyzzyxyzzy", "1").error().detail,
              AllOf(Not(HasSubstr("Did you mean")), HasSubstr("GET /limits")));
}

TEST(ParameterGroups, AWrongChoiceIsAnsweredWithTheNearest) {
  const struct {
    const char *name, *given, *meant;
  } cases[] = {{"material", "glas", "glass"},     {"material", "steel", "metal"},
               {"material", "Glass", "glass"},    {"material", "cast-iron", "cast_iron"},
               {"pattern", "voronoi", "uniform"}, {"unit", "millimeters", "mm"},
               {"physics", "godot", "omi"},       {"repair", "stirct", "strict"}};
  for (const auto& c : cases) {
    const auto parsed = parse_text(c.name, c.given);
    ASSERT_FALSE(parsed) << c.given;
    EXPECT_THAT(parsed.error().detail, HasSubstr(std::string("Did you mean '") + c.meant + "'?"));
  }
  EXPECT_THAT(parse_text("material", "xyzzyxyzzy").error().detail, Not(HasSubstr("Did you mean")));
  EXPECT_THAT(parse_text("fragments", "many").error().detail, Not(HasSubstr("Did you mean")));
}

TEST(ParameterGroups, EveryChoiceIsMeantByItself) {
  for (const ParameterSpec& spec : table().specs())
    for (const std::string& choice : spec.choices)
      EXPECT_EQ(choice_meant_by(spec, choice), choice) << spec.name;
}

}  // namespace
}  // namespace fracture
