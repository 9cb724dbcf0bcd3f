// The plan of a bake from folders, globs and manifests, and the part of it that each shard makes.
#include "server/bake/plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "server/bake/line_faults.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;

struct BakePlanTest : testing::Test {
  test::TemporaryFolder folder;

  void put(const std::string& name) {
    fs::create_directories(fs::path(folder / name).parent_path());
    folder.write(name, "");
  }
  BakePlan plan(const BakeSource& source) {
    Expected<BakePlan> made = plan_bake(source);
    if (!made) throw std::runtime_error(made.error().detail);
    return std::move(*made);
  }
  std::string refused(const BakeSource& source) {
    const Expected<BakePlan> made = plan_bake(source);
    return made ? "" : made.error().detail;
  }
};

std::vector<std::pair<std::string, std::string>> files(const BakePlan& plan) {
  std::vector<std::pair<std::string, std::string>> result;
  for (const BakeJob& job : plan.jobs) result.emplace_back(job.input, job.output);
  return result;
}
using Files = std::vector<std::pair<std::string, std::string>>;

TEST_F(BakePlanTest, AFolderIsAllMeshesBelowItByName) {
  for (const char* name : {"in/b.obj", "in/sub/a.glb", "in/a.STL", "in/readme.md", "in/sub/b.mtl"}) put(name);
  EXPECT_EQ(files(plan({.inputs = {folder / "in"}, .output = "out"})),
            (Files{{folder / "in/a.STL", "out/a.STL.glb"},
                   {folder / "in/b.obj", "out/b.obj.glb"},
                   {folder / "in/sub/a.glb", "out/sub/a.glb.glb"}}));
}

TEST_F(BakePlanTest, LinksToFoldersAreFollowedAndEachFolderIsSearchedOnce) {
  for (const char* name : {"elsewhere/deep/c.obj", "in/sub/a.obj", "in/z.obj"}) put(name);
  fs::create_directory_symlink(folder / "elsewhere", folder / "in/linked");
  fs::create_directory_symlink(folder / "in", folder / "in/sub/loop");
  fs::create_directory_symlink(folder / "in/sub", folder / "in/again");
  fs::create_directory_symlink(folder.path, folder / "in/around");
  fs::create_directory_symlink(folder / "elsewhere/deep", folder / "elsewhere/deep/itself");
  const BakePlan made = plan({.inputs = {folder / "in"}, .output = "out"});
  EXPECT_EQ(files(made), (Files{{folder / "in/linked/deep/c.obj", "out/linked/deep/c.obj.glb"},
                                {folder / "in/sub/a.obj", "out/sub/a.obj.glb"},
                                {folder / "in/z.obj", "out/z.obj.glb"}}));
  EXPECT_TRUE(made.dangling.empty());
}

TEST_F(BakePlanTest, LinksWithoutATargetAreNamed) {
  put("in/a.obj");
  fs::create_symlink("absent.glb", folder / "in/b.glb");
  fs::create_symlink("../absent", folder / "in/props");
  const BakePlan made = plan({.inputs = {folder / "in"}, .output = "out"});
  EXPECT_EQ(files(made),
            (Files{{folder / "in/a.obj", "out/a.obj.glb"}, {folder / "in/b.glb", "out/b.glb.glb"}}))
      << "reading the link says why it cannot be read";
  EXPECT_EQ(made.dangling, std::vector<std::string>{folder / "in/props"});
  EXPECT_EQ(files(plan({.inputs = {folder / "in/*"}, .output = "out"})), files(made));
  const BakePlan second = plan({.inputs = {folder / "in"}, .output = "out", .shard = {1, 2}});
  EXPECT_TRUE(second.dangling.empty()) << "the first shard names it";
  fs::create_directories(folder / "empty");
  fs::create_symlink("../absent", folder / "empty/props");
  EXPECT_EQ(refused({.inputs = {folder / "empty"}, .output = "out"}),
            "No mesh was found in '" + folder / "empty" + "'. The target of the link '" +
                folder / "empty/props" + "' does not exist.");
}

TEST_F(BakePlanTest, GlobsAndFilesLieSideBySide) {
  for (const char* name : {"in/b.obj", "in/c.obj", "in/c.txt", "d.ply"}) put(name);
  EXPECT_EQ(files(plan({.inputs = {folder / "in/*", folder / "d.ply"}, .output = "out/"})),
            (Files{{folder / "d.ply", "out/d.ply.glb"},
                   {folder / "in/b.obj", "out/b.obj.glb"},
                   {folder / "in/c.obj", "out/c.obj.glb"}}));
}

TEST_F(BakePlanTest, OneFileMayHaveAnOutputOfItsOwnName) {
  put("a.obj");
  const BakePlan one = plan({.inputs = {folder / "a.obj"}, .output = folder / "broken.gltf"});
  EXPECT_TRUE(one.single);
  EXPECT_EQ(files(one), (Files{{folder / "a.obj", folder / "broken.gltf"}}));
  fs::create_directory(folder / "out");
  EXPECT_EQ(files(plan({.inputs = {folder / "a.obj"}, .output = folder / "out"})),
            (Files{{folder / "a.obj", folder / "out/a.obj.glb"}}));
}

TEST_F(BakePlanTest, AManifestNamesOutputsAndParametersLineByLine) {
  fs::create_directory(folder / "jobs");
  const std::string manifest = folder.write("jobs/night.ndjson",
                                            "{\"input\": \"../a.obj\", \"output\": \"out/a.glb\"}\n\n"
                                            "{\"input\": \"b.obj\", \"output\": \"out/b.glb\", "
                                            "\"parameters\": {\"sites\": 7, \"material\": \"wood\"}}\n");
  const BakePlan made =
      plan({.manifest = manifest, .parameters = {{"sites", "50", true}, {"seed", "3", true}}});
  EXPECT_EQ(files(made), (Files{{folder / "a.obj", folder / "jobs/out/a.glb"},
                                {folder / "jobs/b.obj", folder / "jobs/out/b.glb"}}));
  const auto named = [&](std::size_t job) {
    std::map<std::string, nlohmann::json> values;
    for (const RawParameter& p : made.jobs[job].parameters) values[p.name] = p.value;
    return values;
  };
  EXPECT_EQ(named(0), (std::map<std::string, nlohmann::json>{{"sites", "50"}, {"seed", "3"}}));
  EXPECT_EQ(named(1),
            (std::map<std::string, nlohmann::json>{{"sites", 7}, {"seed", "3"}, {"material", "wood"}}))
      << "the line's own value wins";
}

TEST_F(BakePlanTest, SaysWhichLineOrPathIsWrong) {
  put("in/a.obj");
  put("in/sub/a.obj");
  fs::create_directory(folder / "empty");
  int manifests = 0;
  const auto manifest = [&](const std::string& line) {
    const std::string first = "{\"input\":\"a\",\"output\":\"b\"}\n";
    return BakeSource{.manifest = folder.write(std::to_string(manifests++) + ".ndjson", first + line + "\n")};
  };
  const std::string line = ".ndjson'";
  for (const auto& [source, part] : std::vector<std::pair<BakeSource, std::string>>{
           {{}, "--manifest"},
           {{.inputs = {"a"}, .manifest = "b"}, "Give either input paths"},
           {{.inputs = {folder / "in"}}, "--output"},
           {{.manifest = "m", .output = "o"}, "leave out --output"},
           {{.manifest = folder / "absent"}, "absent"},
           {{.manifest = folder.write("none.ndjson", "")},
            "none.ndjson' has no jobs. Write one line for each"},
           {{.manifest = folder.write("blank.ndjson", "\n \t\r\n")}, "blank.ndjson' has no jobs"},
           {{.inputs = {folder / "empty"}, .output = "o"},
            "No mesh was found in '" + (folder / "empty") + "'"},
           {{.inputs = {folder / "in/*.ply"}, .output = "o"}, "*.ply"},
           {{.inputs = {folder / "in/a.obj", folder / "in/sub/a.obj"}, .output = "o"},
            "both be written to 'o/a.obj.glb'"},
           {manifest("nonsense"), "Line 2 of '" + (folder / "0.ndjson'")},
           {manifest("[1]"), line},
           {manifest("{\"input\": oak}"), line + ": it is not a JSON object (column 11)"},
           {manifest("{\"input\": \"a\""),
            line + ": the line ends before its JSON object is complete (column 14)"},
           {{.manifest = folder.path}, "Is a directory"},
           {manifest("{\"input\": [\"" + std::string(5000, 'a') + "\"]}"), std::string(190, 'a') + "..."},
           {manifest("{\"input\": \"a\"}"), line + ": 'output' is missing"},
           {manifest(R"({"input": "a", "output": "c", "parameters": {"seed": 1, "seed": 2}})"),
            line + ": it names 'seed' more than once"},
           {manifest("{\"input\": \"a\", \"output\": \"c\", \"parameters\": {\"seed\": 1, \"seed\": 2}}"),
            ": it names 'seed' more than once"},
           {manifest("{\"output\": \"a\"}"), line + ": 'input' is missing"},
           {manifest("{\"input\": 5, \"output\": \"c\"}"), line + ": 'input' must be a path"},
           {manifest("{\"input\": \"a\", \"output\": \"c\", \"sites\": 5}"), line + ": 'sites' is not known"},
           {manifest("{\"input\": \"a\", \"output\": \"c\", \"parameters\": 5}"), line + ": 'parameters'"},
           {manifest("{\"input\": \"c\", \"output\": \"./b\"}"), "both be written"}})
    EXPECT_NE(refused(source).find(part), std::string::npos) << part << " in: " << refused(source);
}

TEST_F(BakePlanTest, EveryWrongLineOfAManifestIsNamed) {
  const std::string manifest = folder.write("m",
                                            R"({"input": "a", "output": "1.glb", "parameters": {"sitess": 4}}
nonsense
{"input": "a", "output": "3.glb", "parameters": {"sites": 4}}
{"input": "a", "output": "4.fbx", "parameters": {"sites": 0, "seed": "x"}}

{"input": "a", "output": "6.glb", "parameters": {"sitess": 4}}
{"input": "a", "output": "7.glb", "parameters": {"sitess": 4}}
{"input": "a", "output": "8.glb", "parameters": {"sitess": 4}}
{"input": "a"}
{"input": "a", "output": "3.glb"}
)");
  const std::string of = " of '" + manifest + "': ";
  const ParameterTable table(100'000, FormatSet::all());
  const auto parse = [&](const std::vector<RawParameter>& given) { return table.parse(given); };
  const auto made = plan_bake({.manifest = manifest}, parse);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kBadParameter);
  std::vector<std::string> said;
  std::istringstream lines(made.error().detail);
  for (std::string line; std::getline(lines, line);) said.push_back(line);
  const auto begins = [](const std::string& start) { return testing::StartsWith(start); };
  EXPECT_THAT(said, testing::ElementsAre(
                        begins("Lines 1, 6 to 8" + of + "'sitess' is not a parameter. Did you mean 'sites'?"),
                        begins("Line 2" + of + "it is not a JSON object"),
                        begins("Line 4" + of + "'.fbx' cannot be written"),
                        testing::AllOf(begins("Line 4" + of), testing::HasSubstr("'sites' must be"),
                                       testing::HasSubstr("'seed' must be")),
                        "Line 9" + of + "'output' is missing.",
                        testing::AllOf(begins("Line 10" + of), testing::HasSubstr("would both be written"))));
  // Each shard reports all mistakes; otherwise every machine would lose a night's work.
  EXPECT_EQ(plan_bake({.manifest = manifest, .shard = {1, 3}}, parse).error().detail, made.error().detail);
}

TEST_F(BakePlanTest, ALineMayNeedTheParametersOfARule) {
  const std::string rules =
      folder.write("rules", R"({"rules": [{"match": {"path": "*"}, "parameters": {"pattern": "impact"}}]})");
  const ParameterTable table(100'000, FormatSet::all());
  const auto parse = [&](const std::vector<RawParameter>& given) { return table.parse(given); };
  const auto detail = [&](const std::string& parameters, const std::string& with) {
    const std::string manifest =
        folder.write("m", "{\"input\": \"a\", \"output\": \"b\", \"parameters\": " + parameters + "}\n");
    const auto made = plan_bake({.manifest = manifest, .rules = with}, parse);
    return made ? "" : made.error().detail;
  };
  EXPECT_THAT(detail(R"({"radius": 1})", ""), testing::HasSubstr("'radius'"));
  EXPECT_EQ(detail(R"({"radius": 1})", rules), "");
  EXPECT_THAT(detail(R"({"radius": 1, "sitess": 4})", rules), testing::HasSubstr("'sitess'"));
}

TEST(LineFaults, DifferentOnesAreCountedBeyondTheMost) {
  LineFaults faults("m");
  for (std::size_t line = 1; line <= LineFaults::kMostFaults + 7; ++line)
    faults.add(line, "Fault " + std::to_string(line) + ".");
  const std::string said = faults.error().detail;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), static_cast<std::ptrdiff_t>(LineFaults::kMostFaults));
  EXPECT_TRUE(said.ends_with("\nAnd 7 more.")) << said.substr(said.size() - 100);
}

TEST_F(BakePlanTest, ShardsAreAPartition) {
  for (int k = 0; k < 23; ++k) put("in/" + std::to_string(k) + ".obj");
  std::set<std::string> seen;
  std::size_t jobs = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const BakePlan shard = plan({.inputs = {folder / "in"}, .output = "o", .shard = {k, 4}});
    EXPECT_EQ(shard.all, 23u);
    EXPECT_GE(shard.jobs.size(), 5u);
    jobs += shard.jobs.size();
    for (const BakeJob& job : shard.jobs) seen.insert(job.input);
  }
  EXPECT_EQ(jobs, 23u);
  EXPECT_EQ(seen.size(), 23u);
}

TEST(ParseShard, TakesAnIndexOrThatOfTheOrchestrator) {
  for (const char* name :
       {"FRACTURE_SHARD", "JOB_COMPLETION_INDEX", "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN"})
    ::unsetenv(name);
  const auto index = [](const std::string& text) {
    const Expected<Shard> shard = parse_shard(text);
    return shard ? static_cast<int>(shard->index) : -1;
  };
  EXPECT_EQ(index("3/16"), 3);
  EXPECT_EQ(parse_shard("3/16")->count, 16u);
  for (const char* bad : {"", "3", "/", "3/", "/3", "16/16", "-1/4", "a/4", "1/0", "1/4x", "auto/4"})
    EXPECT_EQ(index(bad), -1) << bad;
  ::setenv("SLURM_ARRAY_TASK_ID", "7", 1);
  ::setenv("SLURM_ARRAY_TASK_MIN", "5", 1);
  EXPECT_EQ(index("auto/4"), 2);
  EXPECT_EQ(index("auto/2"), -1) << "beyond the count";
  ::setenv("JOB_COMPLETION_INDEX", "1", 1);
  EXPECT_EQ(index("auto/4"), 1);
  for (const char* name : {"JOB_COMPLETION_INDEX", "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN"})
    ::unsetenv(name);
}

}  // namespace
}  // namespace fracture::bake
