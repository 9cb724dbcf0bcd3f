// A bake with a baker that the test controls: what is written, reported, kept and refused; stops and
// failures.
#include "server/bake/run.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stop_token>

#include "server/bake/soundness.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Answers with the mesh's own bytes and its seed. The mesh text can also ask for a refusal, an open result,
/// an exception or a stop.
struct EchoBaker : Baker {
  ParameterTable table{100'000, FormatSet::all()};
  std::atomic<int> asked{0};
  std::stop_source stop;

  Expected<RequestParameters> parse(const std::vector<RawParameter>& given) override {
    return table.parse(given);
  }
  Expected<Baked> bake(const FractureRequest& request, const Execution&, const std::stop_token&) override {
    ++asked;
    const std::string text(reinterpret_cast<const char*>(request.mesh.data()), request.mesh.size());
    if (text == "refuse") return fail(ErrorCode::kMeshNotClosed, "It is open.");
    if (text == "throw") throw std::runtime_error("A bug.");
    if (text == "gone") return fail(ErrorCode::kUnavailable, "The server is gone.");
    if (text == "stop") {
      stop.request_stop();
      return fail(ErrorCode::kCancelled, "Stopped.");
    }
    Baked baked;
    auto file = std::make_shared<std::vector<std::uint8_t>>(text.begin(), text.end());
    file->push_back(static_cast<std::uint8_t>('0' + request.parameters.fracture.seed));
    baked.digest = sha256(std::as_bytes(std::span(*file)));
    baked.file = std::move(file);
    baked.summary.certificate.open_edges = text == "open" ? 3 : 0;
    baked.summary.certificate.relative_error = text == "loses" ? 1e-3 : 1e-15;
    baked.summary.judged = false;
    return baked;
  }
};

struct BakeRunTest : testing::Test {
  test::TemporaryFolder folder;
  EchoBaker baker;
  std::vector<RawParameter> parameters;

  BakePlan plan_of(const std::map<std::string, std::string>& meshes) {
    fs::create_directories(folder / "in");
    for (const auto& [name, text] : meshes) folder.write("in/" + name + ".obj", text);
    Expected<BakePlan> plan =
        plan_bake({.inputs = {folder / "in"}, .output = folder / "out", .parameters = parameters});
    if (!plan) throw std::runtime_error(plan.error().detail);
    return std::move(*plan);
  }
  RunFigures run(const BakePlan& plan, bool force = false, int jobs = 3) {
    RunOptions options;
    options.jobs = jobs;
    options.report = folder / "report";
    options.force = force;
    options.quiet = true;
    return run_bake(plan, baker, options, baker.stop.get_token());
  }
  std::string output(const std::string& name) {
    std::ifstream file(folder / ("out/" + name + ".obj.glb"), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::vector<json> report() {
    std::ifstream file(folder / "report");
    std::vector<json> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(json::parse(line));
    return lines;
  }
};

TEST_F(BakeRunTest, WritesEveryOutputAndALineForEachInTheOrderOfTheJobs) {
  const RunFigures f = run(plan_of({{"a", "x"}, {"b", "y"}, {"c", "refuse"}, {"d", "z"}}));
  EXPECT_EQ(f.made, 3u);
  EXPECT_EQ(f.refused, 1u);
  EXPECT_EQ(output("a") + output("b") + output("d"), "x1y1z1");
  EXPECT_FALSE(fs::exists(folder / "out/c.obj.glb"));
  const std::vector<json> lines = report();
  ASSERT_EQ(lines.size(), 4u);
  const std::string names = "abcd";
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(lines[k].at("input"), folder / ("in/" + names.substr(k, 1) + ".obj"));
    EXPECT_EQ(lines[k].at("status"), k == 2 ? "refused" : "made");
  }
  EXPECT_EQ(lines[2].at("problem").at("type"), "/problems/mesh-not-closed");
  EXPECT_EQ(lines[2].at("problem").at("detail"), "It is open.");
  EXPECT_EQ(lines[0].at("digest"), "sha256:" + sha256(std::string_view("x1")).hex());
  EXPECT_EQ(lines[0].at("mesh"), "sha256:" + sha256(std::string_view("x")).hex());
  EXPECT_EQ(lines[0].at("bytes"), 2);
}

TEST_F(BakeRunTest, MakesAgainOnlyWhatIsNotRight) {
  const std::map<std::string, std::string> meshes{
      {"a", "x"}, {"b", "y"}, {"c", "z"}, {"d", "w"}, {"e", "refuse"}};
  run(plan_of(meshes));
  EXPECT_EQ(run(plan_of(meshes)).kept, 4u);
  EXPECT_EQ(baker.asked, 6) << "what was refused is asked again";
  folder.write("in/a.obj", "other");     // the mesh changed
  folder.write("out/b.obj.glb", "y?");   // the output changed
  fs::remove(folder / "out/c.obj.glb");  // the output is missing
  Expected<BakePlan> again = plan_bake({.inputs = {folder / "in"}, .output = folder / "out"});
  const RunFigures f = run(*again);
  EXPECT_EQ(f.kept, 1u);
  EXPECT_EQ(f.made, 3u);
  EXPECT_EQ(output("a") + output("b") + output("c") + output("d"), "other1y1z1w1");
  parameters = {{"seed", "2", true}};
  EXPECT_EQ(run(plan_of(meshes)).made, 4u) << "other parameters, other outputs";
  EXPECT_EQ(output("d"), "w2");
  EXPECT_EQ(run(plan_of(meshes), true).made, 4u) << "forced";
}

TEST_F(BakeRunTest, AReportThatAKilledRunLeftIsReadAsFarAsItGoes) {
  const std::map<std::string, std::string> meshes{{"a", "x"}, {"b", "y"}};
  run(plan_of(meshes));
  std::ifstream file(folder / "report");
  std::string first, second;
  std::getline(file, first);
  std::getline(file, second);
  folder.write("report", first + "\n" + second.substr(0, second.size() / 2));
  const RunFigures f = run(plan_of(meshes));
  EXPECT_EQ(f.kept, 1u);
  EXPECT_EQ(f.made, 1u);
  EXPECT_EQ(report().size(), 2u) << "every line is whole again";
}

TEST_F(BakeRunTest, AStopLeavesTheRestAndTheNextRunMakesIt) {
  const RunFigures first = run(plan_of({{"a", "x"}, {"b", "stop"}, {"c", "y"}}), false, 1);
  EXPECT_EQ(first.made, 1u);
  EXPECT_EQ(first.cancelled, 2u);
  EXPECT_FALSE(fs::exists(folder / "out/c.obj.glb"));
  baker.stop = {};
  const RunFigures second = run(plan_of({{"b", "z"}}), false, 1);
  EXPECT_EQ(second.kept, 1u);
  EXPECT_EQ(second.made, 2u);
  EXPECT_EQ(output("a") + output("b") + output("c"), "x1z1y1");
}

TEST_F(BakeRunTest, ABakerThatGivesUpLeavesTheRestAndTheNextRunMakesIt) {
  const RunFigures first = run(plan_of({{"a", "x"}, {"b", "gone"}, {"c", "y"}, {"d", "z"}}), false, 1);
  EXPECT_EQ(first.made, 1u);
  EXPECT_EQ(first.unavailable, 1u);
  EXPECT_EQ(first.cancelled, 3u) << "the others are not even tried";
  EXPECT_EQ(baker.asked, 2);
  const RunFigures second = run(plan_of({{"b", "w"}}), false, 1);
  EXPECT_EQ(second.kept, 1u);
  EXPECT_EQ(second.made, 3u);
}

TEST_F(BakeRunTest, ABugInOneJobIsReportedAndTheOthersAreMade) {
  const RunFigures f = run(plan_of({{"a", "x"}, {"b", "throw"}, {"c", "y"}}));
  EXPECT_EQ(f.made, 2u);
  EXPECT_EQ(f.failed, 1u);
  EXPECT_EQ(f.refused, 0u);
  EXPECT_EQ(report()[1].at("status"), "failed");
  EXPECT_EQ(report()[1].at("problem").at("type"), "/problems/internal");
  EXPECT_EQ(report()[1].at("problem").at("detail"), "A bug.");
}

TEST_F(BakeRunTest, TheDepfileNamesTheMeshAndWhatItNames) {
  fs::create_directories(folder / "in");
  folder.write("in/my box.obj", "mtllib box #1.mtl\nmtllib absent.mtl\n");
  folder.write("in/box #1.mtl", "newmtl a\nmap_Kd textures/5$.png\n");
  fs::create_directories(folder / "in/textures");
  folder.write("in/textures/5$.png", "pixels");
  BakePlan plan;
  plan.jobs.push_back({folder / "in/my box.obj", folder / "out/box.glb", {}});
  RunOptions options;
  options.quiet = true;
  options.depfile = folder / "deps/box.d";
  EXPECT_EQ(run_bake(plan, baker, options, {}).made, 1u);
  std::ifstream file(options.depfile);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(text, folder.path + "/out/box.glb: " + folder.path + "/in/my\\ box.obj \\\n  " + folder.path +
                      "/in/box\\ \\#1.mtl \\\n  " + folder.path + "/in/textures/5$$.png\n");
}

TEST_F(BakeRunTest, TheDepfileOfWhatIsKeptIsWrittenAgain) {
  BakePlan plan = plan_of({{"a", "x"}});
  RunOptions options;
  options.quiet = true;
  options.report = folder / "report";
  options.depfile = folder / "a.d";
  EXPECT_EQ(run_bake(plan, baker, options, {}).made, 1u);
  fs::remove(options.depfile);
  EXPECT_EQ(run_bake(plan, baker, options, {}).kept, 1u);
  std::ifstream file(options.depfile);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(text, folder.path + "/out/a.obj.glb: " + folder.path + "/in/a.obj\n");
}

TEST_F(BakeRunTest, NamesThatAreNoUtf8AreReportedAndKeptAsOthers) {
  const std::map<std::string, std::string> meshes{
      {"inv\xff", "refuse"}, {"lat\xe9", "x"}, {"b", "y"}, {"open\xff", "open"}};
  const RunFigures f = run(plan_of(meshes));
  EXPECT_EQ(f.made, 2u);
  EXPECT_EQ(f.refused, 1u);
  EXPECT_EQ(f.unsound, 1u);
  EXPECT_EQ(output("lat\xe9"), "x1");
  ASSERT_EQ(report().size(), 4u);
  EXPECT_EQ(report()[1].at("output"), folder / "out/inv\uFFFD.obj.glb");
  EXPECT_EQ(run(plan_of(meshes)).kept, 2u);
  EXPECT_EQ(report().size(), 4u) << "each has one line";
}

TEST_F(BakeRunTest, ARuleDecidesAndMakesAgainOnlyWhatItChanges) {
  const std::map<std::string, std::string> meshes{{"a", "o lid\n"}, {"b", "o cup\n"}};
  BakePlan plan = plan_of(meshes);
  EXPECT_EQ(run(plan).made, 2u);
  plan.rules = {"r", {{.nodes = {"lid"}, .parameters = {{"seed", 4, false}}}}};
  const RunFigures f = run(plan);
  EXPECT_EQ(f.made, 1u);
  EXPECT_EQ(f.kept, 1u);
  EXPECT_EQ(output("a") + output("b"), "o lid\n4o cup\n1");
  plan.rules = {"r", {{.paths = {"*"}, .parameters = {{"colour", 4, false}}}}};
  EXPECT_EQ(run(plan).refused, 2u);
  EXPECT_EQ(report()[1].at("problem").at("type"), "/problems/unknown-parameter");
}

TEST_F(BakeRunTest, CertificatesThatDoNotHoldAreCountedAndNotKept) {
  const std::map<std::string, std::string> meshes{{"a", "open"}, {"b", "loses"}, {"c", "x"}};
  EXPECT_EQ(run(plan_of(meshes)).unsound, 2u);
  EXPECT_EQ(report()[0].at("status"), "unsound");
  EXPECT_EQ(report()[0].at("certificate").at("open_edges"), 3);
  const RunFigures again = run(plan_of(meshes));
  EXPECT_EQ(again.unsound, 2u) << "a second run says so too";
  EXPECT_EQ(again.kept, 1u);
}

TEST_F(BakeRunTest, WhatCannotBeReadOrWrittenDoesNotStopTheOthers) {
  BakePlan plan = plan_of({{"a", "x"}, {"b", "y"}});
  plan.jobs.push_back({folder / "absent.obj", folder / "out/absent.glb", {}});
  fs::create_directories(folder / "out/b.obj.glb");  // A folder is in the place of the file.
  plan.jobs.push_back({folder / "in/a.obj", folder / "out/wrong.glb", {{"sites", "none", true}}});
  const RunFigures f = run(plan);
  EXPECT_EQ(f.made, 1u);
  EXPECT_EQ(f.unreadable, 1u);
  EXPECT_EQ(f.unwritable, 1u);
  EXPECT_EQ(f.refused, 1u);
  for (const auto& entry : fs::recursive_directory_iterator(folder / "out"))
    EXPECT_NE(entry.path().extension(), ".part") << "nothing half-written";
}

TEST_F(BakeRunTest, AFolderThatCannotBeWrittenToIsFoundBeforeAnythingIsMade) {
  BakePlan plan = plan_of({{"a", "x"}, {"b", "y"}});
  folder.write("file", "no folder");
  for (const char* name : {"1", "2"})
    plan.jobs.push_back({folder / "in/a.obj", folder / "file/" + name + ".glb", {}});
  const RunFigures f = run(plan);
  EXPECT_EQ(f.unwritable, 2u);
  EXPECT_EQ(f.made, 0u);
  EXPECT_EQ(baker.asked, 0);
  EXPECT_FALSE(f.begun);
  EXPECT_FALSE(fs::exists(folder / "out/a.obj.glb"));

  // The report, the page and the depfile are written last, but their paths are tried first.
  plan = plan_of({{"a", "x"}});
  RunOptions options;
  options.quiet = true;
  options.report = folder / "file/report";
  EXPECT_EQ(run_bake(plan, baker, options, {}).unwritable, 1u);
  options.report = "";
  options.depfile = folder / "file/depfile";
  EXPECT_EQ(run_bake(plan, baker, options, {}).unwritable, 1u);
  options.depfile = "";
  plan.html = folder / "file/page.html";
  EXPECT_EQ(run_bake(plan, baker, options, {}).unwritable, 1u);
  plan.html = "";
  for (const std::string& bad : {folder / "file", folder / "file/below", std::string("/proc/x")}) {
    FailureKeeper failures({.folder = bad});
    options.failures = &failures;
    options.stages = "";
    EXPECT_EQ(run_bake(plan, baker, options, {}).unwritable, 1u) << bad;
    options.failures = nullptr;
    options.stages = bad;
    EXPECT_EQ(run_bake(plan, baker, options, {}).unwritable, 1u) << bad;
  }
  options.stages = "";
  EXPECT_EQ(baker.asked, 0);
  Previews previews({}, [](const std::string&) {});
  options.previews = &previews;
  plan.jobs.front().picture = folder / "file/a.png";
  EXPECT_EQ(run_bake(plan, baker, options, {}).unwritable, 1u) << "a picture is asked for too";
  options.no_pictures = "The renderer is missing.";
  EXPECT_TRUE(run_bake(plan, baker, options, {}).begun) << "no picture is drawn";
  EXPECT_EQ(static_cast<std::size_t>(baker.asked), plan.jobs.size());
  for (const auto& entry : fs::recursive_directory_iterator(folder.path))
    EXPECT_NE(entry.path().extension(), ".part") << "what was tried is gone";
}

TEST_F(BakeRunTest, WhatIsRightAlreadyNeedsNoFolderThatCanBeWrittenTo) {
  const BakePlan plan = plan_of({{"a", "x"}, {"b", "y"}});
  EXPECT_EQ(run(plan).made, 2u);
  // A folder is in the place of the unfinished file, so writing fails even for root.
  fs::create_directories(folder / "out/.a.obj.glb.part");
  EXPECT_EQ(run(plan).kept, 2u);
  folder.write("in/a.obj", "z");
  EXPECT_EQ(run(plan, false, 1).unwritable, 1u) << "it has to be made again";
  EXPECT_EQ(baker.asked, 2) << "and is not computed";
}

TEST(IsSound, AsksForClosedFragmentsAndForAPartitionWhereOneIsPromised) {
  const auto summary = [](std::uint64_t open, double error) {
    AnswerSummary result;
    result.certificate.open_edges = open;
    result.certificate.relative_error = error;
    result.judged = false;
    return result;
  };
  EXPECT_TRUE(is_sound(summary(0, 1e-14)));
  EXPECT_FALSE(is_sound(summary(1, 1e-14)));
  EXPECT_FALSE(is_sound(summary(0, 1e-3)));
  // These answers were judged where they were computed, by the bounds of their mesh.
  AnswerSummary judged = summary(0, 1e-8);
  judged.judged = true;
  EXPECT_TRUE(is_sound(judged));
  judged.certificate.unmirrored_caps = 2;
  EXPECT_FALSE(is_sound(judged));
  judged = summary(1, 0);
  judged.judged = true;
  EXPECT_FALSE(is_sound(judged));
  AnswerSummary barycenter = summary(0, 0.2);
  barycenter.partition = false;
  EXPECT_TRUE(is_sound(barycenter));
}

/// Anybody may have changed the report before the next run. It decides what is made again, and must never end
/// the bake.
TEST_F(BakeRunTest, LinesThatNoBakeWroteAreNotBelieved) {
  const BakePlan plan = plan_of({{"a", "a"}});
  run(plan);
  const json line = report().at(0);
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  json device = line;
  device["beside"] = {{{"path", "/dev/zero"}, {"digest", "sha256:" + std::string(64, '0')}}};
  json wrong = line;
  wrong["beside"] = {{{"path", 5}, {"digest", 5}}};
  std::string in_depth = line.dump();
  in_depth.replace(in_depth.size() - 1, 1, ",\"x\":" + deep + "}");
  for (const std::string& forged :
       {in_depth, device.dump(), wrong.dump(), std::string(R"({"output": 5, "status": [], "key": {}})"),
        std::string(R"({"output": "x", "status": 5})"), std::string("[]")}) {
    folder.write("report", forged + "\n");
    baker.asked = 0;
    EXPECT_EQ(run(plan).made, 1u) << forged.substr(0, 60);
    EXPECT_EQ(baker.asked, 1) << "what is not believed is made again";
  }
}

}  // namespace
}  // namespace fracture::bake
