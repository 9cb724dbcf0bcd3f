// Kept failures: within limits, inside their folder, and with a command that repeats the request.
#include "server/service/failure_keeper.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <set>
#include <thread>

#include "server/bake/plan.hpp"
#include "tests/server/support/kept_failures.hpp"
#include "tests/support/full_tests.hpp"

namespace fracture::bake {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::Kept;
using test::kept_in;
using test::read_file;

struct Failure {
  std::string mesh = "a mesh";
  std::vector<RawParameter> parameters{};
  std::vector<std::pair<std::string, std::string>> files{};
  MeshFormat format = MeshFormat::kObj;
};

const ParameterTable& table() {
  static const ParameterTable all(100'000, FormatSet::all());
  return all;
}

/// The request borrows its bytes from `failure`.
FractureRequest request_of(const Failure& failure) {
  const Expected<RequestParameters> parameters = table().parse(failure.parameters);
  if (!parameters) throw std::runtime_error(parameters.error().detail);
  FractureRequest request{std::as_bytes(std::span(failure.mesh)), failure.format, *parameters};
  for (const auto& [name, bytes] : failure.files)
    request.files.push_back({name, std::as_bytes(std::span(bytes))});
  return request;
}

const Error kUnsoundError{ErrorCode::kUnsound, "It is open."};

Failure with_seed(int seed, std::size_t bytes = 10) {
  return {.mesh = std::string(bytes, 'x'), .parameters = {{"seed", std::to_string(seed), true}}};
}

TEST(FailureKeeper, KeepsTheOldestWithinItsBoundsAndCountsTheOthers) {
  const test::TemporaryFolder folder;
  FailureKeeper keeper({.folder = folder / "kept", .max_failures = 3});
  for (int seed = 0; seed < 5; ++seed) keeper.keep(request_of(with_seed(seed)), kUnsoundError);
  EXPECT_EQ(keeper.figures().kept, 3u);
  EXPECT_EQ(keeper.figures().dropped, 2u);
  std::set<int> seeds;
  for (const Kept& kept : kept_in(folder / "kept"))
    seeds.insert(kept.request.at("parameters").at("seed").get<int>());
  EXPECT_EQ(seeds, (std::set<int>{0, 1, 2}));
  // The next process finds the kept failures. Deleting one makes room for another.
  FailureKeeper next({.folder = folder / "kept", .max_failures = 3});
  next.keep(request_of(with_seed(7)), kUnsoundError);
  EXPECT_EQ(next.figures().dropped, 1u);
  fs::remove_all(kept_in(folder / "kept").front().place);
  next.keep(request_of(with_seed(7)), kUnsoundError);
  EXPECT_EQ(next.figures().kept, 1u);
}

TEST(FailureKeeper, BoundsTheBytes) {
  const test::TemporaryFolder folder;
  FailureKeeper keeper({.folder = folder / "kept", .max_bytes = 1 << 20});
  keeper.keep(request_of(with_seed(1, 600'000)), kUnsoundError);
  keeper.keep(request_of(with_seed(2, 600'000)), kUnsoundError);
  keeper.keep(request_of(with_seed(3, 2'000'000)), kUnsoundError);
  keeper.keep(request_of(with_seed(4, 100'000)), kUnsoundError);
  EXPECT_EQ(keeper.figures().kept, 2u);
  EXPECT_EQ(keeper.figures().dropped, 2u);
  Failure many = with_seed(5);
  for (int k = 0; k < 300; ++k) many.files.emplace_back("empty" + std::to_string(k), "");
  keeper.keep(request_of(many), kUnsoundError);
  EXPECT_EQ(keeper.figures().dropped, 3u) << "files without bytes take room too";
}

TEST(FailureKeeper, NoNameLeadsOutOfItsFolderOrHidesAnotherFile) {
  const test::TemporaryFolder folder;
  const std::string long_name(300, 'n');
  const Failure hostile{.files = {{"../../escaped", "0"},
                                  {"/escaped", "1"},
                                  {"a", "2"},
                                  {"a/b", "3"},
                                  {"c/d", "4"},
                                  {"c", "5"},
                                  {"mesh.obj", "6"},
                                  {"", "7"},
                                  {"..", "8"},
                                  {"line\nbreak", "9"},
                                  {std::string("nul\0byte", 8), "10"},
                                  {long_name, "11"},
                                  {"textures\\wood.png", "12"},
                                  {"./x/./y", "13"},
                                  {"request.json", "14"},
                                  {"deep/" + long_name + "/name.png", "15"}}};
  FailureKeeper keeper({.folder = folder / "kept"});
  keeper.keep(request_of(hostile), kUnsoundError, nullptr, "../mesh.obj");
  ASSERT_EQ(keeper.figures().kept, 1u);
  const Kept kept = kept_in(folder / "kept").at(0);
  std::set<std::string> places;
  for (std::size_t k = 0; k < hostile.files.size(); ++k) {
    const std::string file = kept.request.at("files").at(k).at("file");
    EXPECT_TRUE(places.insert(file).second) << file;
    EXPECT_EQ(read_file(kept.place / file), std::to_string(k)) << file;
    EXPECT_TRUE(
        fs::canonical(kept.place / file).string().starts_with(fs::canonical(kept.place / "mesh").string()));
  }
  EXPECT_EQ(kept.request.at("files").at(12).at("file"), "mesh/textures/wood.png");
  EXPECT_EQ(kept.request.at("files").at(2).at("file"), "mesh/a");
  EXPECT_EQ(read_file(kept.place / kept.request.at("mesh").at("file").get<std::string>()), "a mesh");
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path)) files += entry.is_regular_file();
  EXPECT_EQ(files, hostile.files.size() + 2) << "the mesh and request.json, and nothing elsewhere";
}

TEST(FailureKeeper, SaysOnceWhatItCannotWriteAndNeverThrows) {
  const test::TemporaryFolder folder;
  folder.write("file", "");
  std::vector<std::string> said;
  FailureKeeper keeper({.folder = folder / "file/below"},
                       [&](const std::string& line) { said.push_back(line); });
  for (int seed = 0; seed < 3; ++seed) keeper.keep(request_of(with_seed(seed)), kUnsoundError);
  EXPECT_EQ(keeper.figures().unwritten, 3u);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("file/below"), std::string::npos) << said[0];
  FailureKeeper silent({.folder = folder / "file/below"});
  silent.keep(request_of(with_seed(1)), kUnsoundError);
  FailureKeeper none({});
  none.keep(request_of(with_seed(1)), kUnsoundError);
  EXPECT_EQ(none.figures().kept + none.figures().unwritten, 0u);
}

TEST(FailureKeeper, UsesUpWhatAKilledProcessLeftAndLeavesWhatAnotherOneWrites) {
  const test::TemporaryFolder folder;
  FailureKeeper keeper({.folder = folder / "kept"});
  const std::string part =
      folder / ("kept/." + keys_of(request_of(with_seed(1))).result.substr(0, 32) + ".part");
  fs::create_directories(part + "/mesh");
  keeper.keep(request_of(with_seed(1)), kUnsoundError);
  EXPECT_EQ(keeper.figures().known, 1u) << "somebody is writing it";
  fs::last_write_time(part, fs::file_time_type::clock::now() - std::chrono::hours(1));
  keeper.keep(request_of(with_seed(1)), kUnsoundError);
  EXPECT_EQ(keeper.figures().kept, 1u);
  EXPECT_EQ(kept_in(folder / "kept").size(), 1u);
}

TEST(FailureKeeper, TakesFailuresOfManyThreads) {
  const test::TemporaryFolder folder;
  FailureKeeper keeper({.folder = folder / "kept"});
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t)
      threads.emplace_back([&, t] {
        for (int k = 0; k < 10; ++k) keeper.keep(request_of(with_seed((t + k) % 20)), kUnsoundError);
      });
  }
  const std::vector<Kept> all = kept_in(folder / "kept");
  EXPECT_EQ(all.size(), 17u) << "seeds 0 to 16, each once";
  EXPECT_EQ(keeper.figures().kept, 17u);
  EXPECT_EQ(keeper.figures().known, 80u - 17u);
}

/// The words that a shell makes of `command` after `fracture-server bake`.
std::vector<std::string> words_of(std::string command) {
  const std::string program = "fracture-server bake";
  if (!command.starts_with(program)) throw std::runtime_error(command);
  command.replace(0, program.size(), "printf '%s\\0'");
  FILE* const pipe = ::popen(command.c_str(), "r");
  std::string all;
  std::array<char, 4096> block;
  for (std::size_t n = 0; (n = std::fread(block.data(), 1, block.size(), pipe)) > 0;)
    all.append(block.data(), n);
  ::pclose(pipe);
  std::vector<std::string> words;
  for (std::size_t at = 0; at < all.size(); at = all.find('\0', at) + 1) words.emplace_back(all.c_str() + at);
  return words;
}

TEST(FailureKeeper, ItsCommandAsksTheSameAgain) {
  using Given = std::vector<std::pair<std::string, std::string>>;
  int number = 0;
  for (const Given& given : std::vector<Given>{
           {},
           {{"sites", "80"}, {"seed", "9007199254740991"}, {"material", "wood"}},
           {{"levels", "4,20,60"}, {"mass", "0.1"}},
           {{"pattern", "slice"}, {"normals", "0,1,0;-1,0.25,1e-3"}, {"tilt", "0.1"}},
           {{"pattern", "points"}, {"points", "0.1,0.2,0.30000000000000004;-1,-2,-3"}},
           {{"pattern", "impact"}, {"impacts", "0,0.4,0"}},
           {{"stretch_matrix", "1,0,0;0,2,0;0,0,3"}},
           {{"stretch", "3"}, {"grain", "-1,0,0.5"}},
           {{"anchor_plane", "0,0,0;0,1,0"}, {"gravity", "-1,-9.81,0"}, {"broken", "3,5"}},
           {{"interior_name", "it's a \"look\" $HOME `id` \\ %s"}, {"interior_color", "#a0b0c0"}},
           {{"nodes", "left,right"}, {"unit", "cm"}, {"up", "z"}},
           {{"keep_center", "0,0,0"}, {"keep_radius", "0.1"}},
           {{"local_point", "0,0,0;1,1,1"},
            {"local_radius", "0.3"},
            {"local_sites", "5,6"},
            {"delta", "only"}},
           {{"fragment", "9007199254740991"}, {"fragment_sites", "12"}},
           {{"dual", "barycenter"}, {"drop_above", "0.5"}, {"physics", "none"}, {"ue_collision", "ucx"}}}) {
    SCOPED_TRACE(++number);
    Failure failure;
    for (const auto& [name, value] : given) failure.parameters.push_back({name, value, true});
    const FractureRequest request = request_of(failure);
    const test::TemporaryFolder folder;
    FailureKeeper keeper({.folder = folder / "kept"});
    keeper.keep(request, kUnsoundError, nullptr, "my 'mesh'.obj");
    const Kept kept = kept_in(folder / "kept").at(0);
    std::vector<std::string> words = words_of(kept.request.at("command"));
    ASSERT_GE(words.size(), 4u);
    EXPECT_EQ(words[0], "mesh/my 'mesh'.obj");
    EXPECT_EQ(words[1], "-o");
    std::vector<RawParameter> again;
    for (std::size_t k = 3; k < words.size(); ++k) {
      ASSERT_EQ(words[k].substr(0, 2), "--");
      const std::size_t equals = words[k].find('=');
      again.push_back({words[k].substr(2, equals - 2), words[k].substr(equals + 1), true});
    }
    const Expected<RequestParameters> parsed = table().parse(again);
    ASSERT_TRUE(parsed) << parsed.error().detail;
    EXPECT_EQ(parsed->format, MeshFormat::kObj);
    EXPECT_EQ(keys_of({request.mesh, request.format, *parsed}).result, keys_of(request).result)
        << canonical_parameters(*parsed).dump();
  }
}

TEST(FailureKeeper, WhatACommandLineCannotSayIsAManifest) {
  Failure names;
  names.parameters.push_back({"nodes", json::array({"left, or so", "right"}), false});
  Failure points;
  std::string list;
  // The list is longer than a command may be.
  for (int k = 0; k < test::sized(8'000, 20'000); ++k)
    list += (k > 0 ? ";" : "") + std::to_string(k) + ",0.5,0.25";
  points.parameters = {{"pattern", "points", true}, {"points", list, true}};
  for (const Failure& failure : {names, points}) {
    const FractureRequest request = request_of(failure);
    const test::TemporaryFolder folder;
    FailureKeeper keeper({.folder = folder / "kept"});
    keeper.keep(request, kUnsoundError);
    const Kept kept = kept_in(folder / "kept").at(0);
    const std::vector<std::string> words = words_of(kept.request.at("command"));
    ASSERT_GE(words.size(), 2u);
    EXPECT_EQ(words[0], "--manifest");
    const Expected<BakePlan> plan = plan_bake({.manifest = (kept.place / words[1]).string()});
    ASSERT_TRUE(plan) << plan.error().detail;
    const BakeJob& job = plan->jobs.at(0);
    EXPECT_EQ(read_file(job.input), failure.mesh);
    const Expected<RequestParameters> parsed = table().parse(job.parameters);
    ASSERT_TRUE(parsed) << parsed.error().detail;
    EXPECT_EQ(keys_of({request.mesh, request.format, *parsed}).result, keys_of(request).result);
  }
}

}  // namespace
}  // namespace fracture::bake
