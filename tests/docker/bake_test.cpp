// A bake through the farm of docker/compose.yaml, one server of which is killed and comes back.
#include <gtest/gtest.h>

#include <set>

#include "tests/docker/farm.hpp"
#include "tests/server/bake_folder.hpp"

namespace fracture::test {
namespace {

TEST(BakeThroughAFarm, GivesTheBytesOfALocalBakeWhileAServerIsKilledAndComesBack) {
  if (const std::string missing = Farm::missing(); !missing.empty()) GTEST_SKIP() << missing;
  const TemporaryFolder folder;
  constexpr int kMeshes = 20;
  write_meshes(folder, kMeshes);
  const auto bake = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> all{
        FRACTURE_SERVER_PROGRAM, "bake", folder / "in", "-o", folder / out, "-q", "--sites", "200",
        "--allow-refused",       "1"};
    all.insert(all.end(), more.begin(), more.end());
    return ChildProcess(all, folder / (out + ".log"));
  };
  ASSERT_EQ(bake("local", {}).wait(), 0);
  const auto whole = outputs(folder / "local");
  ASSERT_EQ(whole.size(), static_cast<std::size_t>(kMeshes));

  Farm farm("0");
  ChildProcess run = bake(
      "farm", {"-j", "4", "--server", "http://127.0.0.1:" + std::to_string(farm.port), "--patience", "3600"});
  // HAProxy writes down what it did some time after it did it.
  const auto used = [&] {
    std::set<std::string> servers;
    std::istringstream log(farm.log());
    for (std::string line; std::getline(log, line);)
      if (const std::size_t name = line.find("of_a_mesh/"); line.find("\"PUT /meshes/") != std::string::npos)
        servers.insert(line.substr(name, line.find(' ', name) - name));
    return servers.size();
  };
  while (run.alive() && used() < kServers) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  farm.kill(1);
  farm.wait_until(1, "DOWN");
  farm.start(1);
  EXPECT_EQ(run.wait(), 0) << read_file(folder / "farm.log");
  EXPECT_EQ(outputs(folder / "farm"), whole);
  while (used() < kServers) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

}  // namespace
}  // namespace fracture::test
