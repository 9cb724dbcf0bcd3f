// A bake through the farm of docker/compose.yaml. One of its servers is killed and started again.
#include <gtest/gtest.h>

#include "tests/docker/farm.hpp"
#include "tests/server/support/bake_folder.hpp"

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
  ChildProcess local = bake("local", {});
  ASSERT_EQ(exit_code(local, "the local bake"), 0);
  const auto whole = outputs(folder / "local");
  ASSERT_EQ(whole.size(), static_cast<std::size_t>(kMeshes));

  Farm farm("0");
  ChildProcess run = bake(
      "farm", {"-j", "4", "--server", "http://127.0.0.1:" + std::to_string(farm.port), "--patience", "3600"});
  ASSERT_TRUE(eventually(kPatience, "every server to be asked",
                         [&] { return !run.alive() || farm.used_servers() == kServers; }));
  farm.kill(1);
  farm.wait_until(1, "DOWN");
  farm.start(1);
  EXPECT_EQ(exit_code(run, "the bake through the farm"), 0) << read_file(folder / "farm.log");
  EXPECT_EQ(outputs(folder / "farm"), whole);
  EXPECT_EQ(farm.used_servers(), kServers);
}

}  // namespace
}  // namespace fracture::test
