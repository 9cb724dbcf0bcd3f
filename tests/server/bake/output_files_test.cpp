// Output files made from an answer: which files are written with them, which are kept, and which are never
// overwritten.
#include "server/bake/output_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/gltf/gltf_writer.hpp"
#include "server/bake/explain.hpp"
#include "server/bake/run.hpp"
#include "tests/gltf/two_halves.hpp"
#include "tests/server/support/bake_folder.hpp"
#include "tests/server/support/child_process.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::outputs;
using test::read_file;
using testing::HasSubstr;
using testing::Key;
using testing::UnorderedElementsAre;

/// Answers every request with the two halves of a box, as GLB.
struct HalvesBaker : Baker {
  ParameterTable table{100'000, FormatSet::all()};
  int asked = 0;
  std::vector<std::uint8_t> bytes = write_glb(test::two_halves(), {});

  Expected<RequestParameters> parse(const std::vector<RawParameter>& given) override {
    return table.parse(given);
  }
  Expected<Baked> bake(const FractureRequest& request, const Execution&, const std::stop_token&) override {
    ++asked;
    EXPECT_EQ(request.output, OutputFormat::kGlb) << "whatever is made of it";
    Baked baked;
    baked.file = std::make_shared<std::vector<std::uint8_t>>(bytes);
    baked.digest = sha256(std::as_bytes(std::span(bytes)));
    baked.summary.certificate.fragments = 2;
    return baked;
  }
};

struct OutputFiles : testing::Test {
  test::TemporaryFolder folder;
  HalvesBaker baker;

  Expected<BakePlan> plan(const std::string& output) {
    folder.write("m", json{{"input", "in.off"}, {"output", output}}.dump() + "\n");
    if (!fs::exists(folder / "in.off")) folder.write("in.off", "OFF");
    return plan_bake({.manifest = folder / "m"});
  }
  RunFigures run(const std::string& output, const std::stop_token& stop = {}) {
    const Expected<BakePlan> planned = plan(output);
    if (!planned) throw std::runtime_error(planned.error().detail);
    RunOptions options;
    options.report = planned->report;
    options.quiet = true;
    return run_bake(*planned, baker, options, stop);
  }
  json line() {
    std::ifstream file(folder / "m.report");
    std::string text;
    std::getline(file, text);
    return json::parse(text);
  }
  std::string digest(const std::string& name) { return "sha256:" + sha256(read_file(folder / name)).hex(); }
};

TEST_F(OutputFiles, AnObjHasItsMaterialsAndTexturesBesideItAndTheReportNamesAll) {
  EXPECT_EQ(run("out/x.obj").made, 1u);
  EXPECT_THAT(outputs(folder / "out"),
              UnorderedElementsAre(Key("x.obj"), Key("x.mtl"), Key("x_texture_0.png")));
  EXPECT_THAT(read_file(folder / "out/x.obj"), HasSubstr("mtllib x.mtl\n"));
  EXPECT_THAT(read_file(folder / "out/x.mtl"), HasSubstr("map_Kd x_texture_0.png\n"));
  EXPECT_EQ(read_file(folder / "out/x_texture_0.png").substr(1, 3), "PNG");
  const json made = line();
  EXPECT_EQ(made.at("digest"), digest("out/x.obj"));
  EXPECT_EQ(made.at("bytes"), fs::file_size(folder / "out/x.obj"));
  ASSERT_EQ(made.at("beside").size(), 2u);
  for (const json& file : made.at("beside")) {
    const std::string path = file.at("path");
    EXPECT_EQ(fs::path(path).parent_path(), folder / "out");
    EXPECT_EQ(file.at("digest"), digest("out/" + fs::path(path).filename().string()));
    EXPECT_EQ(file.at("bytes"), fs::file_size(path));
  }
}

TEST_F(OutputFiles, PlyAndStlAreOneFile) {
  EXPECT_EQ(run("out/x.ply").made, 1u);
  EXPECT_EQ(line().at("digest"), digest("out/x.ply"));
  EXPECT_FALSE(line().contains("beside"));
  EXPECT_EQ(run("out/x.ply").kept, 1u);
  EXPECT_EQ(run("out/x.stl").made, 1u);
  EXPECT_THAT(outputs(folder / "out"), UnorderedElementsAre(Key("x.ply"), Key("x.stl")));
}

TEST_F(OutputFiles, AnOutputIsKeptOnlyWhenEverythingBesideItIsRight) {
  run("x.obj");
  EXPECT_EQ(run("x.obj").kept, 1u);
  EXPECT_EQ(baker.asked, 1);
  const std::string first = read_file(folder / "x.obj");
  for (const char* name : {"x.obj", "x_texture_0.png", "x.mtl"}) {
    const std::string whole = read_file(folder / name);
    fs::remove(folder / name);
    EXPECT_EQ(run("x.obj").made, 1u) << name;
    EXPECT_EQ(read_file(folder / name), whole);
    folder.write(name, whole + "\n");
    EXPECT_EQ(run("x.obj").made, 1u) << name;
    EXPECT_EQ(read_file(folder / name), whole);
    EXPECT_EQ(run("x.obj").kept, 1u);
  }
  EXPECT_EQ(read_file(folder / "x.obj"), first);
}

TEST_F(OutputFiles, MaterialsThatNoBakeMadeAreNotWrittenOver) {
  folder.write("x.mtl", "newmtl mine\n");
  const Expected<BakePlan> refused = plan("x.obj");
  ASSERT_FALSE(refused) << "before anything is made";
  EXPECT_EQ(refused.error().code, ErrorCode::kBadParameter);
  EXPECT_THAT(refused.error().detail, HasSubstr("Line 1 of"));
  EXPECT_THAT(refused.error().detail, HasSubstr("x.mtl' was not made by a bake"));
  EXPECT_EQ(read_file(folder / "x.mtl"), "newmtl mine\n");
  EXPECT_TRUE(plan("x.ply")) << "which has none";
  fs::remove(folder / "x.mtl");
  fs::create_directory(folder / "x.mtl");
  EXPECT_THAT(plan("x.obj").error().detail, HasSubstr("is a folder"));
}

TEST_F(OutputFiles, ATextureThatNoBakeMadeIsNotWrittenOver) {
  folder.write("x_texture_0.png", "a photograph");
  EXPECT_EQ(run("x.obj").unwritable, 1u);
  EXPECT_EQ(read_file(folder / "x_texture_0.png"), "a photograph");
  EXPECT_THAT(line().at("problem").at("detail").get<std::string>(),
              HasSubstr("x_texture_0.png: the file exists"));
  EXPECT_FALSE(fs::exists(folder / "x.obj")) << "no output without what it names";
  EXPECT_FALSE(fs::exists(folder / "x.mtl"));
}

TEST_F(OutputFiles, WhatAMeshNamesIsNotWrittenOverByWhatLiesBeside) {
  // A bake wrote this file, so it could be overwritten; but the mesh refers to it.
  run("x.obj");
  fs::rename(folder / "x.obj", folder / "in.obj");
  const std::string mtl = read_file(folder / "x.mtl");
  folder.write("m", json{{"input", "in.obj"}, {"output", "x.obj"}}.dump() + "\n");
  RunOptions options;
  options.quiet = true;
  options.report = folder / "m.report";
  EXPECT_EQ(run_bake(*plan_bake({.manifest = folder / "m"}), baker, options, {}).unwritable, 1u);
  EXPECT_THAT(line().at("problem").at("detail").get<std::string>(), HasSubstr("x.mtl: it is a file that"));
  EXPECT_EQ(read_file(folder / "x.mtl"), mtl);
}

TEST_F(OutputFiles, TwoOutputsDoNotShareTheirMaterials) {
  folder.write("in.off", "OFF");
  folder.write("m", json{{"input", "in.off"}, {"output", "x.obj"}}.dump() + "\n" +
                        json{{"input", "in.off"}, {"output", "x.OBJ"}}.dump() + "\n");
  const Expected<BakePlan> refused = plan_bake({.manifest = folder / "m"});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail, HasSubstr("Line 2 of"));
  EXPECT_THAT(refused.error().detail, HasSubstr("the materials of"));
  EXPECT_THAT(refused.error().detail, HasSubstr("would both be written"));
}

TEST_F(OutputFiles, AnAnswerThatIsNoneFailsAndLeavesNothing) {
  baker.bytes.resize(baker.bytes.size() / 2);
  for (const char* output : {"out/x.obj", "out/x.ply", "out/x.stl"})
    EXPECT_EQ(run(output).failed, 1u) << output;
  EXPECT_EQ(line().at("problem").at("type"), "/problems/internal");
  EXPECT_TRUE(outputs(folder / "out").empty());
}

TEST_F(OutputFiles, AStopLeavesNothingHalfWritten) {
  std::stop_source stop;
  stop.request_stop();
  const auto written = write_output(
      folder / "x.ply", OutputKind::kPly, baker.bytes, outputs::VertexColors::kKeep,
      [](const auto&) { return std::nullopt; }, stop.get_token());
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(outputs(folder.path).empty());
}

TEST_F(OutputFiles, ColorsOfAGltfAreLinearThoseOfOtherMeshesStay) {
  EXPECT_EQ(run("x.obj").made, 1u);
  EXPECT_THAT(read_file(folder / "x.obj"), HasSubstr(" 1 0.5 0.25\n"));
  folder.write("in.gltf", R"({"asset": {"version": "2.0"}})");
  folder.write("m", json{{"input", "in.gltf"}, {"output", "y.obj"}}.dump() + "\n");
  RunOptions options;
  options.quiet = true;
  EXPECT_EQ(run_bake(*plan_bake({.manifest = folder / "m"}), baker, options, {}).made, 1u);
  EXPECT_THAT(read_file(folder / "y.obj"), HasSubstr(" 1 0.7354 0.5371\n"));
}

TEST_F(OutputFiles, AnExplanationNamesTheMaterials) {
  const Expected<BakePlan> planned = plan("x.obj");
  ASSERT_TRUE(planned);
  const BakeJob& job = planned->jobs.front();
  EXPECT_THAT(explanation_of(job, {}, {}), HasSubstr("/x.obj with " + (folder / "x.mtl") + "\n"));
}

}  // namespace
}  // namespace fracture::bake
