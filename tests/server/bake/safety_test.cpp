// A bake loses no data: which files and folders it refuses to overwrite, and which files it does not take for
// meshes.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stop_token>
#include <thread>

#include "server/bake/input_file.hpp"
#include "server/bake/output_path.hpp"
#include "server/bake/plan.hpp"
#include "server/bake/result_file.hpp"
#include "tests/server/support/bake_folder.hpp"
#include "tests/server/support/child_process.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct BakeSafety : testing::Test {
  test::TemporaryFolder folder;

  std::string put(const std::string& name, const std::string& text = "") {
    fs::create_directories(fs::path(folder / name).parent_path());
    return folder.write(name, text);
  }
  std::string refused(const BakeSource& source) {
    const Expected<BakePlan> made = plan_bake(source);
    return made ? "" : made.error().detail;
  }
  std::string refused(const std::string& input, const std::string& output) {
    return refused({.inputs = {input}, .output = output});
  }
  void expect_refused(const BakeSource& source, const std::vector<std::string>& parts) {
    const std::string why = refused(source);
    for (const std::string& part : parts)
      EXPECT_NE(why.find(part), std::string::npos) << part << " in: " << why;
  }
  BakePlan plan(const BakeSource& source) {
    Expected<BakePlan> made = plan_bake(source);
    if (!made) throw std::runtime_error(made.error().detail);
    return std::move(*made);
  }
};

std::string glb(const json& document) {
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::uint32_t head[5] = {0x46546C67u, 2u, static_cast<std::uint32_t>(20 + text.size()),
                                 static_cast<std::uint32_t>(text.size()), 0x4E4F534Au};
  return std::string(reinterpret_cast<const char*>(head), sizeof head) + text;
}

const json kPlain = {{"asset", {{"version", "2.0"}, {"generator", "Blender"}}}};
const json kOurs = {{"asset", {{"version", "2.0"}, {"generator", "fracture, algorithm 7"}}}};
/// From a program that keeps extras but writes its own name as the generator.
const json kOursThroughAnEditor = {
    {"asset", {{"version", "2.0"}, {"generator", "Blender"}}},
    {"nodes", {{{"name", "Camera"}}, {{"extras", {{"fracture", {{"certificate", json::object()}}}}}}}}};
const json kAboutFractures = {{"asset", {{"version", "2.0"}, {"generator", "Blender"}}},
                              {"nodes", {{{"name", "fracture"}, {"extras", {{"fracture", "of a leg"}}}}}}};

// -- file extensions

TEST(KindOfOutput, IsTheEndingAndNoOtherEndingIsWritten) {
  for (const char* path : {"a.glb", "a.GLB", "a", "a/b.c/d", ".glb", "a.b/c"})
    EXPECT_EQ(kind_of_output(path), OutputKind::kGlb) << path;
  for (const char* path : {"a.gltf", "a.b.GLTF", "x/a.gltf"})
    EXPECT_EQ(kind_of_output(path), OutputKind::kGltf) << path;
  for (const char* path : {"a.obj", "a.glb.obj", "a.OBJ"})
    EXPECT_EQ(kind_of_output(path), OutputKind::kObj) << path;
  EXPECT_EQ(kind_of_output("a.PLY"), OutputKind::kPly);
  EXPECT_EQ(kind_of_output("x.y/a.Stl"), OutputKind::kStl);
  const json known{".glb", ".gltf", ".obj", ".ply", ".stl"};
  for (const char* path : {"a.fbx", "a.obj.off", "a.json", "a.mtl", "a.glb2", "a.part", "a.", "a.objx"}) {
    const auto kind = kind_of_output(path);
    ASSERT_FALSE(kind) << path;
    EXPECT_EQ(kind.error().code, ErrorCode::kBadParameter);
    EXPECT_NE(kind.error().detail.find("'" + fs::path(path).extension().string() + "'"), std::string::npos);
    EXPECT_EQ(kind.error().extra->at("known"), known);
    for (const std::string ending : known)
      EXPECT_NE(kind.error().detail.find(ending), std::string::npos) << "what is possible";
  }
}

TEST(KindOfOutput, AnObjMayNotBeCalledWhatNoLineOfTextCanName) {
  for (const char* path : {"a\nb.obj", "x/-s.obj", " a.obj", "a\r.OBJ"}) {
    const auto kind = kind_of_output(path);
    ASSERT_FALSE(kind) << path;
    EXPECT_NE(kind.error().detail.find(".mtl"), std::string::npos) << kind.error().detail;
  }
  EXPECT_TRUE(kind_of_output("a-b c.obj"));
  EXPECT_TRUE(kind_of_output("-x/a.obj"));
  EXPECT_TRUE(kind_of_output("a\nb.stl"));
}

TEST(KindOfOutput, OnlyAnObjHasMaterialsBesideIt) {
  EXPECT_EQ(materials_beside("x.y/crate.v2.obj"), "x.y/crate.v2.mtl");
  EXPECT_EQ(materials_beside("A.OBJ"), "A.mtl");
  for (const char* path : {"a.glb", "a.ply", "a", "-", "a.fbx"})
    EXPECT_EQ(materials_beside(path), "") << path;
}

TEST_F(BakeSafety, AnEndingThatIsNotWrittenIsRefusedInManifestsToo) {
  const std::string mesh = put("a.obj");
  expect_refused({.inputs = {mesh}, .output = folder / "x.off"}, {"'.off'", "x.off"});
  const std::string manifest = put("m.ndjson",
                                   "{\"input\": \"a.obj\", \"output\": \"b.glb\"}\n"
                                   "{\"input\": \"a.obj\", \"output\": \"c.fbx\"}\n");
  expect_refused({.manifest = manifest}, {"Line 2 of '" + manifest + "'", "'.fbx'", "c.fbx"});
}

// -- inputs are kept

TEST_F(BakeSafety, AnOutputThatIsTheInputIsRefusedHoweverItIsSpelt) {
  const std::string mesh = put("in/a.glb", "mesh");
  fs::create_directories(folder / "in/sub");
  fs::create_symlink("a.glb", folder / "in/link.glb");
  fs::create_symlink("in", folder / "other");
  fs::create_hard_link(mesh, folder / "in/hard.glb");
  for (const char* name : {"in/a.glb", "in/./a.glb", "in/sub/../a.glb", "in//a.glb", "in/link.glb",
                           "other/a.glb", "in/hard.glb", "other/sub/../link.glb"}) {
    const std::string why = refused(mesh, folder / name);
    EXPECT_NE(why.find("overwrite the input"), std::string::npos) << name << ": " << why;
    EXPECT_NE(why.find(mesh), std::string::npos) << why;
  }
  EXPECT_NE(refused(folder / "in/link.glb", mesh).find("overwrite the input"), std::string::npos);
  EXPECT_EQ(refused(mesh, folder / "in/b.glb"), "");
  const std::string relative = fs::relative(mesh).string();
  EXPECT_NE(refused(mesh, relative).find("overwrite"), std::string::npos) << relative;
  EXPECT_EQ(test::read_file(mesh), "mesh");
}

TEST_F(BakeSafety, NoLineOfAManifestWritesOverAnInputOfAnotherOrTheManifest) {
  put("a.glb"), put("b.glb");
  const auto manifest = [&](const std::string& text) { return BakeSource{.manifest = put("m", text)}; };
  expect_refused(manifest("{\"input\": \"a.glb\", \"output\": \"a.glb\"}\n"),
                 {"Line 1 of", "overwrite the input"});
  expect_refused(manifest("{\"input\": \"a.glb\", \"output\": \"x/../b.glb\"}\n"
                          "{\"input\": \"b.glb\", \"output\": \"c.glb\"}\n"),
                 {"Line 1 of", "overwrite the input", "b.glb"});
  expect_refused(manifest("{\"input\": \"a.glb\", \"output\": \"m\"}\n"),
                 {"Line 1 of", "overwrite the manifest"});
  fs::create_symlink("c", folder / "d");
  expect_refused(manifest("{\"input\": \"a.glb\", \"output\": \"c/x.glb\"}\n"
                          "{\"input\": \"b.glb\", \"output\": \"./c/x.glb\"}\n"),
                 {"Line 2 of", "both be written to"});
  fs::create_directory(folder / "c");
  expect_refused(manifest("{\"input\": \"a.glb\", \"output\": \"c/x.glb\"}\n"
                          "{\"input\": \"b.glb\", \"output\": \"d/x.glb\"}\n"),
                 {"Line 2 of", "both be written to"});
}

TEST_F(BakeSafety, EveryShardRefusesWhatAnyShardWouldLose) {
  put("a.obj"), put("b.glb");
  const std::string manifest = put("m",
                                   "{\"input\": \"a.obj\", \"output\": \"b.glb\"}\n"
                                   "{\"input\": \"b.glb\", \"output\": \"c.glb\"}\n");
  for (const std::size_t shard : {0u, 1u})
    expect_refused({.manifest = manifest, .shard = {shard, 2}}, {"Line 1 of", "overwrite the input"});
}

TEST_F(BakeSafety, ReportAndDepfileAreNoInputNoOutputAndNothingElseThatIsThere) {
  const std::string mesh = put("a.obj", "v 0 0 0\n"), out = folder / "a.glb";
  expect_refused({.inputs = {mesh}, .output = out, .report = mesh}, {"overwrite the input"});
  expect_refused({.inputs = {mesh}, .output = out, .report = out}, {"both be written"});
  expect_refused({.inputs = {mesh}, .output = out, .depfile = mesh}, {"overwrite the input"});
  expect_refused({.inputs = {mesh}, .output = out, .depfile = folder / "./a.glb"}, {"both be written"});
  expect_refused({.inputs = {mesh}, .output = out, .report = folder / "r", .depfile = folder / "r"},
                 {"both be written"});
  expect_refused({.inputs = {mesh}, .output = out, .report = "-"}, {"--report"});
  expect_refused({.inputs = {mesh}, .output = "-", .depfile = folder / "d"}, {"--depfile"});
  expect_refused({.inputs = {"-"}, .output = out, .depfile = folder / "d"}, {"--depfile"});
  for (const char* text : {"notes\n", "{\"a\": 1}", "{\n  \"output\": 5\n}\n", "\n\nx"})
    expect_refused({.inputs = {mesh}, .output = out, .report = put("notes", text)}, {"is not a bake report"});
  for (const char* text :
       {"", "{\"input\": \"a\", \"output\": \"b\", \"status\": \"made\"}\n", "{\"bytes\": 5, \"cer"})
    EXPECT_EQ(refused({.inputs = {mesh}, .output = out, .report = put("report", text)}), "") << text;
}

// -- paths that cannot be written to

TEST_F(BakeSafety, DevicesPipesSocketsFoldersAndDescriptorsAreNoOutputs) {
  const std::string mesh = put("a.obj");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  (folder / "socket").copy(address.sun_path, sizeof address.sun_path - 1);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  fs::create_symlink("/dev/stdout", folder / "link");
  fs::create_symlink("pipe", folder / "pipe link");
  for (const auto& [path, what] :
       std::vector<std::pair<std::string, std::string>>{{"/dev/null", "a device"},
                                                        {"/dev/stdout", "an open file descriptor"},
                                                        {"/dev/fd/1", "an open file descriptor"},
                                                        {"/proc/self/fd/1", "an open file descriptor"},
                                                        {folder / "link", "an open file descriptor"},
                                                        {folder / "pipe", "a pipe"},
                                                        {folder / "pipe link", "a pipe"},
                                                        {folder / "socket", "a socket"}}) {
    const std::string why = refused(mesh, path);
    EXPECT_NE(why.find("'" + path + "' is " + what), std::string::npos) << path << ": " << why;
  }
  ::close(socket);
  fs::create_directory(folder / "out");
  for (const char* output : {"out", "out/", "new/"})
    expect_refused(
        {.manifest = put("m", "{\"input\": \"a.obj\", \"output\": \"" + std::string(output) + "\"}\n")},
        {"Line 1 of", "folder"});
  fs::create_directories(folder / "out/a.obj.glb");
  expect_refused({.inputs = {mesh}, .output = folder / "out"}, {"a.obj.glb' is a folder"});
}

TEST_F(BakeSafety, SeveralMeshesNeedAFolder) {
  const std::string a = put("a.obj"), b = put("b.obj"), file = put("out.glb");
  expect_refused({.inputs = {a, b}, .output = file}, {"is not a folder"});
  expect_refused({.inputs = {folder / "*.obj"}, .output = folder / "new.glb"}, {"the name of a file"});
  EXPECT_EQ(refused({.inputs = {a, b}, .output = folder / "new"}), "");
  expect_refused({.inputs = {a, b}, .output = "-"}, {"one mesh"});
  expect_refused({.inputs = {"-", a}, .output = folder / "new"}, {"Standard input"});
  expect_refused({.inputs = {"-"}, .output = folder / "new/"}, {"Standard input"});
  for (const char* line :
       {"{\"input\": \"-\", \"output\": \"a.glb\"}\n", "{\"input\": \"a.obj\", \"output\": \"-\"}\n"})
    expect_refused({.manifest = put("m", line)}, {"Line 1 of", "'-'"});
}

TEST_F(BakeSafety, AFileCalledMinusInAManifestIsAFile) {
  const fs::path before = fs::current_path();
  fs::current_path(folder.path);
  folder.write("m", "{\"input\": \"./-\", \"output\": \"b/../-out\"}\n");
  const Expected<BakePlan> made = plan_bake({.manifest = "m"});
  fs::current_path(before);
  ASSERT_TRUE(made) << made.error().detail;
  EXPECT_EQ(made->jobs.front().input, "./-");
  EXPECT_EQ(made->jobs.front().output, "-out");
}

// -- results are not meshes

/// Decides by the format that the file extension names.
bool is_result(const std::string& path) {
  return is_result_file(path, *format_from_extension(fs::path(path).extension().string().substr(1)));
}

TEST_F(BakeSafety, ResultsAreKnownByTheirContent) {
  EXPECT_TRUE(is_result(put("ours.glb", glb(kOurs) + "binary")));
  EXPECT_TRUE(is_result(put("ours.gltf", kOurs.dump(2))));
  EXPECT_TRUE(is_result(put("edited.glb", glb(kOursThroughAnEditor))));
  EXPECT_FALSE(is_result(put("plain.glb", glb(kPlain))));
  EXPECT_FALSE(is_result(put("about.glb", glb(kAboutFractures))));
  EXPECT_FALSE(is_result(put("plain.gltf", kPlain.dump())));
  EXPECT_FALSE(is_result(put("short.glb", "glTF")));
  EXPECT_FALSE(is_result(put("cut.glb", glb(kOurs).substr(0, 40))));
  EXPECT_FALSE(is_result(put("wrong.gltf", "[\"fracture, algorithm 7\"]")));
  EXPECT_FALSE(is_result(folder / "absent.glb"));
  EXPECT_TRUE(is_result(put("ours.obj", "# fracture, algorithm 7\n# metres, y up\n")));
  EXPECT_TRUE(is_result(
      put("ours.ply", "ply\nformat binary_little_endian 1.0\ncomment fracture, algorithm 7\nelement")));
  EXPECT_TRUE(is_result(put("ours.STL", "fracture, algorithm 7; metres")));
  EXPECT_FALSE(is_result(put("plain.obj", "# about fracture, algorithm 7\n")));
  EXPECT_FALSE(is_result(put("plain.ply", "ply\nformat ascii 1.0\ncomment fracture, algorithm 7\n")));
  EXPECT_FALSE(is_result(put("plain.stl", "solid fracture, algorithm 7")));
  EXPECT_FALSE(is_result(put("short.stl", "fracture")));
  EXPECT_FALSE(is_result(put("other.off", "# fracture, algorithm 7\n")));
}

TEST_F(BakeSafety, ResultsBelowAFolderOrAGlobAreSkippedAndCounted) {
  put("in/a.obj"), put("in/b.glb", glb(kPlain)), put("in/c.glb", glb(kAboutFractures));
  put("in/a.obj.glb", glb(kOurs)), put("in/sub/old.gltf", kOurs.dump()),
      put("in/edited.glb", glb(kOursThroughAnEditor));
  for (const std::string& input : {folder / "in", folder / "in/*"}) {
    const BakePlan made = plan({.inputs = {input}, .output = folder / "in"});
    std::vector<std::string> inputs;
    for (const BakeJob& job : made.jobs) inputs.push_back(fs::path(job.input).filename().string());
    EXPECT_EQ(inputs, (std::vector<std::string>{"a.obj", "b.glb", "c.glb"})) << input;
    EXPECT_EQ(made.skipped.size(), input.ends_with("*") ? 2u : 3u);
  }
  EXPECT_EQ(plan({.inputs = {folder / "in/a.obj.glb"}, .output = folder / "again.glb"}).jobs.size(), 1u)
      << "a result that is named is meant";
  put("results/x.glb", glb(kOurs));
  expect_refused({.inputs = {folder / "results"}, .output = folder / "out"},
                 {"No mesh was found", "only one result of an earlier bake"});
}

TEST_F(BakeSafety, WhatAReportSaysWasMadeIsAResultAlsoAfterAnotherProgramHasWrittenIt) {
  const std::string result = put("in/a.obj.glb", glb(kPlain)), other = put("in/refused.glb", glb(kPlain));
  put("in/a.obj");
  const std::string lines = json{{"output", result}, {"status", "made"}}.dump() + "\n" +
                            json{{"output", other}, {"status", "refused"}}.dump() + "\n";
  for (const char* name : {"in/bake.ndjson", "in/bake.1-of-2.ndjson", "elsewhere"}) {
    const std::string report = put(name, lines);
    BakeSource source{.inputs = {folder / "in"}, .output = folder / "out"};
    if (std::string(name) == "elsewhere") source.report = report;
    const BakePlan made = plan(source);
    EXPECT_EQ(made.jobs.size(), 2u) << name;
    EXPECT_EQ(made.skipped, std::vector<std::string>{result}) << name;
    fs::remove(report);
  }
}

TEST_F(BakeSafety, KeptFailuresAreNoMeshes) {
  put("in/a.obj"), put("in/failures/00/mesh/b.obj");
  EXPECT_EQ(plan({.inputs = {folder / "in"}, .output = folder / "out"}).jobs.size(), 2u);
  EXPECT_EQ(plan({.inputs = {folder / "in"}, .output = folder / "out", .failures = folder / "in/./failures"})
                .jobs.size(),
            1u);
}

// -- reading

TEST_F(BakeSafety, AFolderAsAMeshCannotBeRead) {
  EXPECT_FALSE(read_bytes(folder.path));
  EXPECT_EQ(errno, EISDIR);
}

TEST_F(BakeSafety, AStopEndsTheWaitForAPipe) {
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  const int writer =
      ::open((folder / "pipe").c_str(), O_RDWR | O_CLOEXEC);  // so that opening it to read does not block
  ASSERT_GE(writer, 0);
  ASSERT_EQ(::write(writer, "v 0", 3), 3);
  std::stop_source stop;
  std::jthread stopper([&] { stop.request_stop(); });
  EXPECT_FALSE(read_bytes(folder / "pipe", stop.get_token()));
  EXPECT_EQ(errno, ECANCELED);
  ::close(writer);
}

TEST(InputFile, KnowsTheFormatByParameterThenNameThenContent) {
  const auto format = [](const std::string& path, const std::string& bytes,
                         std::optional<MeshFormat> given = {}) {
    RequestParameters parameters;
    parameters.format = given;
    const auto input = to_input(path, bytes, parameters);
    return input ? std::optional(input->format) : std::nullopt;
  };
  const std::string off = "OFF\n0 0 0\n";
  EXPECT_EQ(format("-", off), MeshFormat::kOff);
  EXPECT_EQ(format("-", off, MeshFormat::kObj), MeshFormat::kObj);
  EXPECT_EQ(format("mesh", off), MeshFormat::kOff);
  EXPECT_EQ(format("mesh.v2", off), MeshFormat::kOff);
  EXPECT_EQ(format("mesh.STL", off), MeshFormat::kStl);
  EXPECT_EQ(format("-", "v 0 0 0\n"), std::nullopt);
  const RequestParameters nothing;
  EXPECT_EQ(to_input("-", "v 0 0 0\n", nothing).error().code, ErrorCode::kUnknownFormat);
  EXPECT_EQ(to_input("-", "", nothing).error().code, ErrorCode::kEmptyBody);
}

}  // namespace
}  // namespace fracture::bake
