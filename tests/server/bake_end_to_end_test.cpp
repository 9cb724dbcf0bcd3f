// bake of a folder as a process: the same bytes in shards, one at a time, and after having been killed
// half-way.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

#include "tests/server/server_process.hpp"
#include "tests/server/temporary_folder.hpp"

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

/// Boxes of different sides, and one mesh that cannot be broken.
void write_meshes(const TemporaryFolder& folder, int count) {
  fs::create_directories(folder / "in/poison");
  for (int k = 0; k < count; ++k) {
    const std::string x = std::to_string(1 + k);
    folder.write("in/box" + x + ".obj",
                 "v 0 0 0\nv " + x + " 0 0\nv " + x + " 1 0\nv 0 1 0\nv 0 0 1\nv " + x + " 0 1\nv " + x +
                     " 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  }
  folder.write("in/poison/sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
}

std::map<std::string, std::string> outputs(const std::string& folder) {
  std::map<std::string, std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().extension() == ".ndjson") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files[entry.path().lexically_relative(folder).string()] = {std::istreambuf_iterator<char>(file), {}};
  }
  return files;
}

std::size_t lines_in(const std::string& path) {
  std::ifstream file(path);
  std::size_t lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  return lines;
}

TEST(BakeOfAFolder, GivesTheSameBytesHoweverItIsDividedOrInterrupted) {
  const TemporaryFolder folder;
  constexpr int kMeshes = 24;
  write_meshes(folder, kMeshes);
  const auto bake = [&](const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> all{"bake", folder / "in", "-o", folder / out, "--sites", "300", "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  EXPECT_EQ(Process(bake("one", {"-j", "1"})).wait(), 3) << "the sheet is refused, and the exit code says so";
  const auto whole = outputs(folder / "one");
  EXPECT_EQ(whole.size(), static_cast<std::size_t>(kMeshes));
  EXPECT_FALSE(whole.contains("poison/sheet.obj.glb"));
  EXPECT_EQ(lines_in(folder / "one/bake.ndjson"), kMeshes + 1u);

  EXPECT_EQ(Process(bake("two", {"-j", "2", "--allow-refused", "1"})).wait(), 0);
  EXPECT_EQ(outputs(folder / "two"), whole);

  for (const char* shard : {"0/2", "1/2"})
    EXPECT_EQ(Process(bake("shards", {"--shard", shard, "--allow-refused", "1"})).wait(), 0);
  EXPECT_EQ(outputs(folder / "shards"), whole);

  {
    Process killed(bake("killed", {"-j", "2"}));
    while (lines_in(folder / "killed/bake.ndjson") < 3)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    killed.signal(SIGKILL);
    killed.wait();
  }
  for (const auto& [name, bytes] : outputs(folder / "killed"))
    if (!name.ends_with(".part")) EXPECT_EQ(bytes, whole.at(name)) << name;
  EXPECT_EQ(Process(bake("killed", {"-j", "2", "--allow-refused", "1"})).wait(), 0);
  EXPECT_EQ(outputs(folder / "killed"), whole) << "nothing half-written is left";
}

TEST(BakeOfAFolder, StopsOnSigtermAndGoesOnLater) {
  const TemporaryFolder folder;
  write_meshes(folder, 24);
  const std::vector<std::string> arguments{
      "bake",    folder / "in", "-o", folder / "out",    "--sites", "300",
      "--quiet", "-j",          "1",  "--allow-refused", "1"};
  Process stopped(arguments);
  while (lines_in(folder / "out/bake.ndjson") < 2) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  stopped.signal(SIGTERM);
  const int code = stopped.wait();
  EXPECT_TRUE(code == 130 || code == 0) << code << ": or it was done already";
  EXPECT_EQ(Process(arguments).wait(), 0);
  EXPECT_EQ(outputs(folder / "out").size(), 24u);
}

}  // namespace
}  // namespace fracture::test
