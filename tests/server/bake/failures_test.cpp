// Answers whose certificate fails, and bugs: nothing is written, the failure is reported by name, and it is
// kept so that it can be reproduced.
#include <gtest/gtest.h>

#include <filesystem>

#include "common/pipeline/algorithm_version.hpp"
#include "server/bake/engine_around.hpp"
#include "server/bake/run.hpp"
#include "tests/server/support/bake_folder.hpp"
#include "tests/server/support/child_process.hpp"
#include "tests/server/support/engine_in_process.hpp"
#include "tests/server/support/kept_failures.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::Kept;
using test::kept_in;
using test::read_file;

/// The real engine, except for some numbers of sites.
class UnsoundEngine final : public EngineAround {
 public:
  static constexpr std::uint32_t kOpen = 5;        ///< reports open edges in an answer, as older servers did
  static constexpr std::uint32_t kUnmirrored = 6;  ///< reports caps without a mirror image in an answer
  static constexpr std::uint32_t kRefused = 7;     ///< refuses its own answer
  static constexpr std::uint32_t kBroken = 8;      ///< throws InternalError
  static constexpr std::uint32_t kNoMemory = 9;    ///< throws std::bad_alloc

  UnsoundEngine() : EngineAround(test::engine_in_process()) {}

  Expected<Cut> cut(const Solid& solid, const CutBase& base, const FractureParameters& parameters,
                    const Selection& selection, const Execution& execution) const override {
    if (parameters.sites == kRefused)
      return fracture::fail(ErrorCode::kUnsound, "13 edges are open.", "", {{"open_edges", 13}});
    if (parameters.sites == kBroken) throw InternalError("cell 3 has no face");
    if (parameters.sites == kNoMemory) throw std::bad_alloc();
    Expected<Cut> made = EngineAround::cut(solid, base, parameters, selection, execution);
    if (made && parameters.sites == kOpen) made->fractured.set.certificate.open_edges = 13;
    if (made && parameters.sites == kUnmirrored) made->fractured.set.certificate.unmirrored_caps = 3;
    return made;
  }
};

struct BakeFailures : testing::Test {
  test::TemporaryFolder folder;
  std::unique_ptr<Baker> baker = local_baker({}, std::make_unique<UnsoundEngine>());
  std::string said;  ///< standard error of the last bake

  void SetUp() override { test::write_meshes(folder, 2); }

  RunFigures bake(const BakeSource& source, FailureKeeper* failures = nullptr, bool quiet = true) {
    const Expected<BakePlan> plan = plan_bake(source);
    if (!plan) throw std::runtime_error(plan.error().detail);
    RunOptions options;
    options.report = plan->report;
    options.quiet = quiet;
    options.failures = failures;
    testing::internal::CaptureStderr();
    RunFigures figures = run_bake(*plan, *baker, options, {});
    said = testing::internal::GetCapturedStderr();
    return figures;
  }
  BakeSource one(std::uint32_t sites) const {
    return {.inputs = {folder / "in/box1.obj"},
            .output = folder / "one.glb",
            .parameters = {{"sites", std::to_string(sites), true}},
            .report = folder / "report"};
  }
  std::vector<json> report(const std::string& name) const {
    std::ifstream file(folder / name);
    std::vector<json> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(json::parse(line));
    return lines;
  }
};

TEST_F(BakeFailures, AnUnsoundAnswerOfOneFileIsNotWrittenAndWhatWasThereStays) {
  for (const std::uint32_t sites :
       {UnsoundEngine::kOpen, UnsoundEngine::kUnmirrored, UnsoundEngine::kRefused}) {
    SCOPED_TRACE(sites);
    folder.write("one.glb", "before");
    const RunFigures f = bake(one(sites));
    EXPECT_EQ(f.unsound, 1u);
    EXPECT_EQ(f.made + f.failed + f.refused, 0u);
    EXPECT_EQ(f.sentence, "");
    EXPECT_EQ(read_file(folder / "one.glb"), "before");
    EXPECT_NE(said.find("box1.obj: unsound: "), std::string::npos) << said;
    const json line = report("report").at(0);
    EXPECT_EQ(line.at("status"), "unsound");
    EXPECT_EQ(line.at("problem").at("type"), "/problems/unsound");
    EXPECT_EQ(line.at("certificate").at("open_edges"), sites == UnsoundEngine::kUnmirrored ? 0 : 13);
    fs::remove(folder / "one.glb");
    fs::remove(folder / "report");
    bake(one(sites));
    EXPECT_FALSE(fs::exists(folder / "one.glb"));
  }
  EXPECT_EQ(bake(one(10)).made, 1u);
}

TEST_F(BakeFailures, ManyGoOnAndWriteAllButTheUnsound) {
  std::string manifest;
  const std::uint32_t sites[] = {
      10, UnsoundEngine::kOpen, UnsoundEngine::kRefused, UnsoundEngine::kBroken, UnsoundEngine::kNoMemory,
      11};
  for (const std::uint32_t k : sites)
    manifest +=
        json{{"input", "in/box1.obj"}, {"output", std::to_string(k)}, {"parameters", {{"sites", k}}}}.dump() +
        "\n";
  const RunFigures f = bake({.manifest = folder.write("m", manifest)});
  EXPECT_EQ(f.made, 2u);
  EXPECT_EQ(f.unsound, 2u);
  EXPECT_EQ(f.failed, 2u);
  for (const std::uint32_t k : sites) EXPECT_EQ(fs::exists(folder / std::to_string(k)), k >= 10) << k;
  std::vector<std::string> status;
  for (const json& line : report("m.report")) status.push_back(line.at("status"));
  EXPECT_EQ(status, (std::vector<std::string>{"made", "unsound", "unsound", "failed", "failed", "made"}));
}

TEST_F(BakeFailures, WarningsAndNotesAreSaidAndReportedApartForOneAndForMany) {
  // Five of six sides, which causes a note, and a separate square, which causes a warning.
  folder.write(
      "in/box1.obj",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\n"
      "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nf 9 10 11 12\n");
  BakeSource dropping = one(10);
  dropping.parameters.push_back({"sheets", "drop", true});
  ASSERT_EQ(bake(dropping, nullptr, false).made, 1u);
  const json line = report("report").at(0);
  ASSERT_EQ(line.at("warnings").size(), 1u) << line;
  ASSERT_EQ(line.at("notes").size(), 1u) << line;
  const auto warning = line["warnings"][0].get<std::string>(), note = line["notes"][0].get<std::string>();
  EXPECT_TRUE(warning.starts_with("1 thin piece (2 of 12 triangles")) << warning;
  EXPECT_TRUE(note.starts_with("1 hole was filled with 2 triangles")) << note;
  const std::string first = "box1.obj: warning: " + warning, second = "box1.obj: note: " + note;
  EXPECT_NE(said.find(first), std::string::npos) << said;
  EXPECT_NE(said.find(second), std::string::npos) << said;
  fs::create_directory(folder / "out");
  ASSERT_EQ(bake({.inputs = {folder / "in/box1.obj"},
                  .output = folder / "out",
                  .parameters = {{"sites", "10", true}, {"sheets", "drop", true}}},
                 nullptr, false)
                .made,
            1u);
  EXPECT_NE(said.find(first), std::string::npos) << said;
  EXPECT_NE(said.find(second), std::string::npos) << said;
  EXPECT_EQ(read_file(folder / "out/box1.obj.glb"), read_file(folder / "one.glb"));
  BakeSource elsewhere = dropping;
  elsewhere.output = folder / "two.glb";
  ASSERT_EQ(bake(elsewhere).made, 1u);
  EXPECT_NE(said.find(first), std::string::npos) << said;
  EXPECT_EQ(said.find(second), std::string::npos) << "it is quiet about notes: " << said;
}

TEST_F(BakeFailures, AFileThatTheMeshNamesIsNotWrittenOver) {
  std::string gltf = read_file(folder / "in/gltf/box.gltf");
  gltf.replace(gltf.find("box%20data/box.bin"), 18, "data.glb");  // A buffer may have any file name.
  folder.write("in/gltf/box.gltf", gltf);
  fs::rename(folder / "in/gltf/box data/box.bin", folder / "in/gltf/data.glb");
  const std::string before = read_file(folder / "in/gltf/data.glb");
  BakeSource source = one(10);
  source.inputs = {folder / "in/gltf/box.gltf"};
  source.output = folder / "in/gltf/../gltf/data.glb";
  EXPECT_EQ(bake(source).unwritable, 1u);
  EXPECT_NE(said.find("data.glb"), std::string::npos) << said;
  EXPECT_NE(said.find("box.gltf names"), std::string::npos) << said;
  EXPECT_EQ(read_file(folder / "in/gltf/data.glb"), before);
  EXPECT_EQ(report("report").at(0).at("status"), "unwritable");
  source.output = folder / "one.glb";
  source.depfile = folder / "in/gltf/data.glb";
  RunOptions options;
  options.depfile = source.depfile;
  EXPECT_EQ(run_bake(*plan_bake(source), *baker, options, {}).unwritable, 1u);
  EXPECT_EQ(read_file(folder / "in/gltf/data.glb"), before);
}

// -- kept failures

TEST_F(BakeFailures, AKeptFailureFailsAgainFromWhatWasKept) {
  for (const std::uint32_t sites : {UnsoundEngine::kOpen, UnsoundEngine::kRefused, UnsoundEngine::kBroken}) {
    SCOPED_TRACE(sites);
    const std::string failures = folder / ("failures" + std::to_string(sites));
    FailureKeeper keeper({.folder = failures, .program = "fracture-server test"});
    BakeSource source = one(sites);
    source.inputs = {folder / "in/gltf/box.gltf"};
    source.parameters.push_back({"material", "wood", true});
    bake(source, &keeper);
    EXPECT_EQ(keeper.figures().kept, 1u);
    const std::vector<Kept> all = kept_in(failures);
    ASSERT_EQ(all.size(), 1u);
    const auto& [place, request] = all.front();
    const bool broken = sites == UnsoundEngine::kBroken;
    EXPECT_TRUE(request.at("key").get<std::string>().starts_with(place.filename().string()));
    EXPECT_EQ(request.at("program"), "fracture-server test");
    EXPECT_EQ(request.at("algorithm"), kAlgorithmVersion);
    EXPECT_EQ(request.at("error").at("type"), broken ? "/problems/internal" : "/problems/unsound");
    EXPECT_EQ(request.at("parameters").at("material"), "wood");
    EXPECT_EQ(request.at("parameters").at("sites"), sites);
    if (broken) {
      EXPECT_EQ(request.at("error").at("detail"), "cell 3 has no face");
    } else {
      EXPECT_EQ(request.at("certificate").at("open_edges"), 13);
    }
    EXPECT_EQ(read_file(place / "mesh/box.gltf"), read_file(folder / "in/gltf/box.gltf"));
    EXPECT_EQ(read_file(place / "mesh/box data/box.bin"), read_file(folder / "in/gltf/box data/box.bin"));

    // The same mesh and parameters have the same key, so the failure is recognized.
    BakeSource again{.inputs = {(place / request.at("mesh").at("file").get<std::string>()).string()},
                     .output = folder / "again.glb"};
    for (const auto& [name, value] : request.at("parameters").items())
      again.parameters.push_back({name, value, false});
    const RunFigures f = bake(again, &keeper);
    EXPECT_EQ(f.unsound + f.failed, 1u);
    EXPECT_EQ(keeper.figures().kept, 1u);
    EXPECT_EQ(keeper.figures().known, 1u);
    EXPECT_EQ(kept_in(failures).size(), 1u);
  }
}

TEST_F(BakeFailures, WhatIsRefusedMadeOrOutOfMemoryIsNotKept) {
  FailureKeeper keeper({.folder = folder / "failures"});
  EXPECT_EQ(bake(one(10), &keeper).made, 1u);
  EXPECT_EQ(bake(one(UnsoundEngine::kNoMemory), &keeper).failed, 1u);
  BakeSource sheet = one(10);
  sheet.inputs = {folder / "in/poison/sheet.obj"};
  EXPECT_EQ(bake(sheet, &keeper).refused, 1u);
  EXPECT_TRUE(fs::is_empty(folder / "failures")) << "it was only tried";
}

}  // namespace
}  // namespace fracture::bake
