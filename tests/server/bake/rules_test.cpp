// Rules of a bake: which files match, which rule wins, which rules are refused by name, and the effect of the
// rules on a bake.
#include "server/bake/rules.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <stop_token>

#include "server/bake/depfile.hpp"
#include "server/bake/explain.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct BakeRulesTest : testing::Test {
  test::TemporaryFolder folder;

  std::string path = folder / "rules.json";
  Expected<RuleFile> read(const std::string& text) { return read_rules(folder.write("rules.json", text)); }
  RuleFile rules(const std::string& text) {
    Expected<RuleFile> file = read(text);
    if (!file) throw std::runtime_error(file.error().detail);
    return std::move(*file);
  }
  std::string refused(const std::string& text) {
    const Expected<RuleFile> file = read(text);
    return file ? "" : file.error().detail;
  }
};

std::string with_match(const std::string& match) {
  return R"({"rules": [{"match": )" + match + R"(, "parameters": {"sites": 9}}]})";
}

std::vector<RuleMatch> find_rules(const RuleFile& file, const std::string& path,
                                  const MeshNames& names = {}) {
  const Expected<std::vector<RuleMatch>> matches = RuleTally(file).find(path, names);
  if (!matches) throw std::runtime_error(matches.error().detail);
  return *matches;
}

/// The first rule that matches.
std::optional<RuleMatch> find_rule(const RuleFile& file, const std::string& path,
                                   const MeshNames& names = {}) {
  const std::vector<RuleMatch> matches = find_rules(file, path, names);
  return matches.empty() ? std::nullopt : std::optional(matches.front());
}

bool matches(const RuleFile& file, const std::string& path, const MeshNames& names = {}) {
  return find_rule(file, path, names).has_value();
}

TEST_F(BakeRulesTest, APathMatchesAsAWholeOrFromASlashOn) {
  const RuleFile glass = rules(with_match(R"({"path": "*_glass*"})"));
  EXPECT_TRUE(matches(glass, "big_glass.obj"));
  EXPECT_TRUE(matches(glass, "/assets/a_glass/door.obj")) << "an asterisk goes over slashes";
  EXPECT_FALSE(matches(glass, "glass.obj"));
  const RuleFile props = rules(with_match(R"({"path": "props/?[0-9].obj"})"));
  EXPECT_TRUE(matches(props, "props/a1.obj"));
  EXPECT_TRUE(matches(props, "/assets/props/a1.obj"));
  EXPECT_FALSE(matches(props, "my_props/a1.obj")) << "an end of a path begins behind a slash";
  EXPECT_FALSE(matches(props, "props/ab.obj"));
  EXPECT_TRUE(matches(rules(with_match(R"({"path": "a\\*.obj"})")), "a*.obj"));
  EXPECT_FALSE(matches(rules(with_match(R"({"path": "a\\*.obj"})")), "ab.obj"));
}

TEST_F(BakeRulesTest, OneOfAListHasToMatchAndOfSeveralListsEach) {
  const RuleFile file =
      rules(with_match(R"({"path": "*.glb", "material": ["oak*", "pine"], "node": "lid"})"));
  EXPECT_TRUE(matches(file, "a.glb", {{"lid", "body"}, {"oak dark"}}));
  EXPECT_TRUE(matches(file, "a.glb", {{"lid"}, {"iron", "pine"}}));
  EXPECT_FALSE(matches(file, "a.obj", {{"lid"}, {"pine"}}));
  EXPECT_FALSE(matches(file, "a.glb", {{"lid2"}, {"pine"}})) << "a name matches as a whole";
  EXPECT_FALSE(matches(file, "a.glb", {{"lid"}, {"pines"}}));
  EXPECT_FALSE(matches(file, "a.glb"));
  EXPECT_EQ(find_rule(file, "a.glb", {{"lid"}, {"pine"}})->why,
            "path '*.glb' matches, node 'lid' matches 'lid', material 'pine' matches 'pine'");
}

TEST_F(BakeRulesTest, MatchingIsBoundedAndStops) {
  std::string list;
  for (int k = 0; k < 100; ++k)
    list += (k > 0 ? ", \"" : "\"") + std::string("*a*a*a*") + std::to_string(k) + "b\"";
  const RuleFile file =
      rules(R"({"rules": [{"match": {"path": "*"}, "parameters": {}},
      {"match": {"node": [)" +
            list + R"(]}, "parameters": {}}, {"match": {"path": "q*", "node": "z"}, "parameters": {}}]})");
  MeshNames names;
  for (int k = 0; k < 20'000; ++k) names.nodes.insert(std::string(1000, 'a') + std::to_string(k));
  RuleTally tally(file);
  const auto decided = tally.find("a.obj", names);
  ASSERT_TRUE(decided) << "what comes after the rule that decides refuses nothing";
  EXPECT_EQ(decided->at(0).rule, 0u);
  EXPECT_TRUE(tally.warnings().empty()) << "what was not compared is not known";
  RuleFile late = file;
  late.rules.erase(late.rules.begin());
  const auto refused = RuleTally(late).find("a.obj", names);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(refused.error().detail,
            "Its 20,000 names need more than 200,000,000 comparisons with the patterns of '" + path +
                "' up to rule 1. Use simpler patterns.");
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = RuleTally(late).find("a.obj", names, stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
}

TEST_F(BakeRulesTest, PatternsWithoutWildcardsCostNothing) {
  std::string all;
  for (int k = 0; k < 1000; ++k)
    all += (k > 0 ? ", " : "") + std::string(R"({"match": {"node": "n)") + std::to_string(k) +
           R"("}, "parameters": {}})";
  const RuleFile file = rules("{\"rules\": [" + all + "]}");
  MeshNames names;
  for (int k = 0; k < 100'000; ++k) names.nodes.insert("m" + std::to_string(k));
  names.nodes.insert("n999");
  EXPECT_EQ(find_rule(file, "a.obj", names)->rule, 999u) << "100 million comparisons of names";
}

TEST_F(BakeRulesTest, WhatAQuoteHoldsIsShortAndPrintable) {
  const RuleFile file = rules(with_match(R"({"node": "*"})"));
  EXPECT_EQ(find_rule(file, "a.obj", {.nodes = {"a\x1b[31m\n"}})->why, "node '*' matches 'a\\x1b[31m\\x0a'");
  EXPECT_EQ(find_rule(file, "a.obj", {.nodes = {std::string("a\0b", 3)}})->why, "node '*' matches 'a\\x00b'");
  EXPECT_EQ(find_rule(file, "a.obj", {.nodes = {std::string(5000, 'a')}})->why,
            "node '*' matches '" + std::string(200, 'a') + "...'");
  const BakeJob job{.input = "a\n\x1b.obj", .output = "b.glb", .parameters = {}};
  EXPECT_EQ(explanation_of(job, {}, parameters_of(job, {}, {})),
            "a\\x0a\\x1b.obj -> b.glb\n  every parameter has its default value\n");
  const std::string long_text = refused(with_match("{\"path\": [[\"" + std::string(5000, 'a') + "\"]]}"));
  EXPECT_NE(long_text.find("it was [[\"" + std::string(190, 'a')), std::string::npos) << long_text;
  EXPECT_LT(long_text.size(), 500u);
}

TEST_F(BakeRulesTest, ANameIsComparedAsAWhole) {
  const RuleFile file = rules(with_match(R"({"node": "lid"})"));
  EXPECT_FALSE(matches(file, "a.obj", {.nodes = {std::string("lid\0x", 5)}}));
  EXPECT_TRUE(matches(file, "a.obj", {.nodes = {"lid"}}));
}

TEST_F(BakeRulesTest, TheFirstThatMatchesDecidesAndLinesGoOverRulesOverTheCommandLine) {
  const RuleFile file = rules(R"({"rules": [
      {"match": {"path": "*_glass*"}, "parameters": {"material": "glass", "seed": 5}},
      {"match": {"path": "*"}, "parameters": {"sites": 7}}]})");
  const auto values = [&](const BakeJob& job) {
    json result;
    for (const RawParameter& p : parameters_of(job, file, find_rules(file, job.input)).all) {
      EXPECT_FALSE(result.contains(p.name)) << p.name << " is given twice";
      result[p.name] = p.value;
    }
    return result;
  };
  const std::vector<RawParameter> command_line{{"seed", "3", true}, {"sites", "50", true}};
  EXPECT_EQ(values({.input = "a_glass.obj", .output = "", .parameters = command_line}),
            (json{{"material", "glass"}, {"seed", 5}, {"sites", "50"}}))
      << "the second rule has no say";
  EXPECT_EQ(values({.input = "a.obj", .output = "", .parameters = command_line}),
            (json{{"seed", "3"}, {"sites", 7}}));
  const std::string manifest =
      folder.write("m", R"({"input": "a_glass.obj", "output": "b.glb", "parameters": {"seed": 8}})");
  const Expected<BakePlan> plan = plan_bake({.manifest = manifest, .parameters = command_line});
  ASSERT_TRUE(plan) << plan.error().detail;
  EXPECT_EQ(values(plan->jobs[0]), (json{{"material", "glass"}, {"seed", 8}, {"sites", "50"}}));
  EXPECT_EQ(
      explanation_of(plan->jobs[0], file,
                     parameters_of(plan->jobs[0], file, find_rules(file, plan->jobs[0].input))),
      folder.path + "/a_glass.obj -> " + folder.path + "/b.glb\n  rule 1 of " + path +
          ": path '*_glass*' matches\n  material=\"glass\"  (rule 1)\n  seed=8  (line 1 of the manifest)\n"
          "  sites=50  (command line)\n");
  const BakeJob bare{.input = "a.obj", .output = "b.glb", .parameters = {}};
  EXPECT_EQ(explanation_of(bare, {}, parameters_of(bare, {}, {})),
            "a.obj -> b.glb\n  every parameter has its default value\n");
}

TEST_F(BakeRulesTest, RulesByNameBecomeEntriesForTheirParts) {
  const RuleFile file = rules(R"({"rules": [
      {"match": {"node": "Window*"}, "parameters": {"material": "glass", "fragments": 80}},
      {"match": {"node": "Roof", "material": ["Slate", "Tile*"]}, "parameters": {"rough_amplitude": 0.02, "fragments": 9}},
      {"match": {"path": "*.glb"}, "parameters": {"material": "brick", "seed": 4}},
      {"match": {"node": "*"}, "parameters": {"material": "wood"}}]})");
  const MeshNames names{{"Window_1", "Roof"}, {"Slate"}};
  const auto values = [&](const BakeJob& job) {
    json result;
    for (const RawParameter& p : parameters_of(job, file, find_rules(file, job.input, names)).all) {
      EXPECT_FALSE(result.contains(p.name)) << p.name << " is given twice";
      result[p.name] = p.value;
    }
    return result;
  };
  const json glass = {{"node", "Window*"}, {"material", "glass"}}, roof = {{"node", "Roof"},
                                                                           {"slot", {"Slate", "Tile*"}},
                                                                           {"rough_amplitude", 0.02},
                                                                           {"material", "brick"}};
  EXPECT_EQ(values({.input = "a.glb", .output = "", .parameters = {}}),
            (json{{"material", "brick"}, {"seed", 4}, {"fragments", 80}, {"assign", {glass, roof}}}))
      << "the rule for the whole mesh decides all other parts, and the first rule decides the number";
  json of_wood = roof;
  of_wood["stretch"] = 6;
  of_wood["material"] = "wood";
  const BakeJob obj{
      .input = "a.obj", .output = "", .parameters = {{"stretch", "6", true}, {"material", "wood", true}}};
  EXPECT_EQ(values(obj)["assign"], (json{glass, of_wood, {{"node", "*"}, {"material", "wood"}}}))
      << "without a material of its own, an entry has the properties of the command line";
  BakeJob line{.input = "a.glb",
               .output = "",
               .parameters = {{"assign", "Door:metal", true}},
               .own = {{"material", "ice", false},
                       {"assign", json::parse(R"([{"part": 0, "material": "stone"}])"), false}}};
  put_over(line.own, line.parameters);
  json icy_glass = glass, icy_roof = roof;
  icy_glass["material"] = icy_roof["material"] = "ice";
  EXPECT_EQ(values(line)["assign"], (json{{{"part", 0}, {"material", "stone"}}, icy_glass, icy_roof}))
      << "a manifest line goes over all rules";
}

TEST_F(BakeRulesTest, WhatIsWrongIsNamedWithItsPlaceAndLimit) {
  const std::string rule = "Rule 1 of '" + path + "': ", file = "The rules file '" + path + "': ";
  const auto long_text = [](std::size_t n) { return std::string(n, 'a'); };
  const std::pair<std::string, std::string> cases[] = {
      {"{\n\n\"rules\": oak}", file + "line 3, column 10: not valid JSON."},
      {"oak", file + "line 1, column 1: not valid JSON."},
      {"{}\n}", file + "line 2, column 1: not valid JSON."},
      {"{\"rules\": [\n", file + "the JSON ends before it is complete (line 2, column 1)."},
      {"", file + "the JSON ends before it is complete (line 1, column 1)."},
      {R"({"rules": [], "rules": []})", file + "the file names 'rules' more than once."},
      {"[]", file + "the file must be a JSON object with the list 'rules'."},
      {R"({"rules": []})", file + "there must be 1 to 1,000 rules; it has 0."},
      {R"({"rules": [1], "version": 2})", file + "'version' is not known; only 'rules' is allowed."},
      {R"({"rules": [1]})", rule + "it must be an object."},
      {R"({"rules": [{"match": {"path": "*"}}]})", rule + "'parameters' is missing."},
      {R"({"rules": [{"parameters": {}}]})", rule + "'match' is missing."},
      {R"({"rules": [{"match": {"path": "*"}, "parameters": {}, "set": 1}]})",
       rule + "'set' is not known; only match and parameters are allowed."},
      {R"({"rules": [{"match": {"path": "*"}, "parameters": [1]}]})",
       rule + "'parameters' must be an object; it was [1]."},
      {with_match("{}"), rule + "'match' must be an object with at least one of path, node and material."},
      {with_match(R"({"file": "*"})"),
       rule + "'match' has 'file'; only path, node and material are allowed."},
      {with_match(R"({"path": 3})"), rule + "'path' must be a pattern or a list of patterns; it was 3."},
      {with_match(R"({"node": []})"), rule + "'node' must have 1 to 100 patterns; it had 0."},
      {with_match(R"({"node": ""})"), rule + "a pattern of 'node' must have 1 to 1000 bytes; it had 0."},
      {with_match(R"({"node": ["a", "b\u0000c"]})"),
       rule + "a pattern of 'node' must not contain a NUL character; it was \"b\\u0000c\"."},
      {with_match("{\"path\": \"" + long_text(1001) + "\"}"),
       rule + "a pattern of 'path' must have 1 to 1000 bytes; it had 1001."},
      {long_text(kMaxRuleFileBytes + 1),
       file + "the file has more than 1,048,576 bytes, which is the limit."},
  };
  for (const auto& [text, detail] : cases) EXPECT_EQ(refused(text), detail) << text.substr(0, 100);
  EXPECT_EQ(refused(with_match("{\"path\": \"" + long_text(1000) + "\"}")), "");
  EXPECT_EQ(read_rules(folder / "absent").error().detail,
            "The rules file '" + (folder / "absent") + "' cannot be read: No such file or directory.");
  EXPECT_EQ(read_rules(folder.path).error().detail,
            "The rules file '" + folder.path + "' cannot be read: Is a directory.");
}

TEST_F(BakeRulesTest, ParametersOfARuleAreCheckedWithThoseOfTheCommandLineBeforeAnythingIsMade) {
  const ParameterTable table{100'000, FormatSet::all()};
  const auto parse = [&](const std::vector<RawParameter>& given) { return table.parse(given); };
  const RuleFile file = rules(R"({"rules": [{"match": {"path": "a"}, "parameters": {"sites": 7}},
                                            {"match": {"path": "b"}, "parameters": {"radius": 0.1}}]})");
  const std::vector<RawParameter> impact{{"pattern", "impact", true}};
  EXPECT_TRUE(check_rules(file, impact, parse));
  const auto alone = check_rules(file, {}, parse);
  ASSERT_FALSE(alone);
  EXPECT_EQ(alone.error().code, ErrorCode::kBadParameter);
  EXPECT_TRUE(alone.error().detail.starts_with("Rule 2 of '" + path + "': ")) << alone.error().detail;
  const auto unknown = check_rules(
      rules(R"({"rules": [{"match": {"path": "a"}, "parameters": {"colour": 7}}]})"), impact, parse);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::kUnknownParameter);
  EXPECT_EQ(unknown.error().pointer, "colour");
}

TEST_F(BakeRulesTest, RulesThatDecideNothingAreSaid) {
  const RuleFile file = rules(R"({"rules": [
      {"match": {"path": "*.obj"}, "parameters": {}},
      {"match": {"node": ["lid", "cap"]}, "parameters": {}},
      {"match": {"path": "b*"}, "parameters": {}},
      {"match": {"path": "c*", "material": "oak"}, "parameters": {}}]})");
  EXPECT_TRUE(file.by_names());
  EXPECT_FALSE(rules(with_match(R"({"path": "a"})")).by_names());
  RuleTally tally(file);
  EXPECT_TRUE(tally.find("a.glb", {{"lid"}, {}}));
  EXPECT_TRUE(tally.find("b.obj", {}));
  EXPECT_TRUE(tally.find("c.obj", {{}, {"pine"}}));
  EXPECT_EQ(
      tally.warnings(),
      (std::vector<std::string>{
          "Rule 3 of '" + path +
              "' (path \"b*\") is never applied, because an earlier rule already applies to every mesh that this rule matches.",
          "Rule 4 of '" + path +
              "' (path \"c*\", material \"oak\") matches no mesh. Bake reads the names of nodes and materials only from "
              "glTF, GLB and OBJ files."}));
  tally.add_unread("d.obj");
  EXPECT_EQ(tally.warnings().size(), 2u) << "d.obj is called otherwise";
  tally.add_unread("c2.obj");
  EXPECT_EQ(tally.warnings().size(), 1u) << "c2.obj might be of oak";
}

TEST_F(BakeRulesTest, TheFileIsReadWithThePlanWrittenOverByNothingAndNamedInTheDepfile) {
  const std::string mesh = folder.write("a.obj", "o a\n");
  folder.write("rules.json", with_match(R"({"path": "*"})"));
  const Expected<BakePlan> plan = plan_bake({.inputs = {mesh}, .output = folder / "a.glb", .rules = path});
  ASSERT_TRUE(plan) << plan.error().detail;
  EXPECT_EQ(plan->rules.rules.size(), 1u);
  EXPECT_EQ(depfile_text(plan->jobs[0], {}, plan->rules.path),
            folder.path + "/a.glb: " + mesh + " \\\n  " + path + "\n");
  const Expected<BakePlan> lost =
      plan_bake({.inputs = {mesh}, .output = folder / "a.glb", .rules = path, .depfile = path});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().detail,
            "Writing '" + path + "' would overwrite the rules '" + path + "': choose another path.");
  EXPECT_FALSE(plan_bake({.inputs = {mesh}, .output = folder / "a.glb", .rules = mesh}));
}

}  // namespace
}  // namespace fracture::bake
