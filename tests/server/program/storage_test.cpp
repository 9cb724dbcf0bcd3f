// The program with little memory, and with folders. Memory that was requested but is not available is
// refused; a folder that another server owns is waited for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/import/make_files.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

using ::testing::HasSubstr;

const std::string kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\n"
    "f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

const std::string kObj = "Content-Type: model/obj\r\n";

std::string contents_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The output and the exit code of the program after it was started with these arguments.
struct Ended {
  explicit Ended(std::vector<std::string> arguments, const std::string& output = "/dev/null") {
    arguments.insert(arguments.begin(), "serve");
    Process process(std::move(arguments), output);
    for (std::string line = process.error_line(); !line.empty(); line = process.error_line()) said += line;
    code = process.wait();
  }
  std::string said;
  int code = 0;
};

const std::vector<std::string> kTwo = {"--threads", "2", "--import-workers", "2"};

std::vector<std::string> with(std::vector<std::string> flags) {
  flags.insert(flags.end(), kTwo.begin(), kTwo.end());
  return flags;
}

/// The smallest value, according to the message of a server that has too little.
std::uint64_t least_memory() {
  const Ended refused(with({"--memory", "64MiB"}));
  const std::string words = "the smallest value that works is ";
  const std::size_t at = refused.said.find(words);
  EXPECT_NE(at, std::string::npos) << refused.said;
  return at == std::string::npos ? 0 : std::stoull(refused.said.substr(at + words.size()));
}

TEST(SmallMemory, WhatIsReadyReadsACubeFromTheLeastMemoryOn) {
  const std::uint64_t least = least_memory();
  ASSERT_GT(least, 64u);
  ASSERT_LT(least, 512u);
  EXPECT_NE(Ended(with({"--memory", std::to_string(least - 1) + "MiB"})).code, 0);
  std::vector<std::uint64_t> sizes = {least, least + 1};
  for (std::uint64_t size = least + 16; size < 512; size += 16) sizes.push_back(size);
  sizes.push_back(512);
  const std::string glb = Tetrahedron().glb();
  for (const std::uint64_t size : sizes) {
    SCOPED_TRACE(size);
    const ServeProcess server(with({"--memory", std::to_string(size) + "MiB"}));
    EXPECT_EQ(ask(server.admin_port, "GET", "/readyz").status, 200);
    for (int k = 0; k < 2; ++k) {
      const Reply obj =
          ask(server.port, "POST", "/fracture?format=obj&sites=5", kObj, kCube + "# " + std::to_string(k));
      EXPECT_EQ(obj.status, 200) << obj.body.substr(0, 300);
    }
    const Reply of_glb =
        ask(server.port, "POST", "/fracture?sites=5", "Content-Type: model/gltf-binary\r\n", glb);
    EXPECT_EQ(of_glb.status, 200) << of_glb.body.substr(0, 300);
    const std::string metrics = ask(server.admin_port, "GET", "/metrics").body;
    EXPECT_THAT(metrics, HasSubstr("fracture_imports_total{outcome=\"imported\"} 3"));
    for (const char* outcome : {"crashed", "limited", "no-room"})
      EXPECT_THAT(metrics, HasSubstr("fracture_imports_total{outcome=\"" + std::string(outcome) + "\"} 0"));
  }
}

TEST(Folders, OneThatCannotBeHadIsRefusedAtTheStart) {
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "x";
  for (const char* setting : {"--cache-dir", "--keep-failures"})
    for (const std::string& bad :
         {std::string("/proc"), std::string("/proc/x"), folder / "file", folder / "file/below"}) {
      const Ended refused(with({"--port", "0", "--admin-port", "0", setting, bad}));
      EXPECT_NE(refused.code, 0) << setting << " " << bad << "\n" << refused.said;
      EXPECT_THAT(refused.said, HasSubstr(std::string(setting) + ": the folder '"));
      EXPECT_THAT(refused.said, HasSubstr("Choose a folder that the server can write to."));
      EXPECT_THAT(refused.said, Not(HasSubstr("filesystem error")));
      EXPECT_THAT(refused.said, Not(HasSubstr("serving on")));
    }
}

TEST(Folders, AServerStartedWhileItsPredecessorDrainsGetsTheFolderWithItsJobs) {
  const TemporaryFolder folder;
  ServeProcess first({"--cache-dir", folder.path});
  const std::string job =
      ask(first.port, "POST", "/fracture?format=obj&sites=5", kObj + "Prefer: respond-async\r\n", kCube)
          .json()
          .value("id", "");
  ASSERT_FALSE(job.empty());
  const auto state_of = [&job](std::uint16_t port) {
    return ask(port, "GET", "/jobs/" + job).json().value("state", "");
  };
  ASSERT_TRUE(eventually(kPatience, "the job to be done", [&] { return state_of(first.port) == "done"; }));

  const ServeProcess second({"--cache-dir", folder.path});
  EXPECT_EQ(ask(second.admin_port, "GET", "/readyz").status, 503);
  EXPECT_EQ(ask(second.port, "GET", "/jobs/" + job).status, 503);
  EXPECT_EQ(ask(second.port, "POST", "/fracture?format=obj&sites=6", kObj, kCube).status, 200);
  first.signal(SIGTERM);
  EXPECT_EQ(first.wait(), 0);
  EXPECT_TRUE(eventually(kPatience, "the second server to be ready",
                         [&] { return ask(second.admin_port, "GET", "/readyz").status == 200; }));
  EXPECT_EQ(state_of(second.port), "done");
}

TEST(PrintedConfig, StartsAServerWithLessMemoryThanTheMachineThatPrintedIt) {
  const TemporaryFolder folder;
  ASSERT_EQ(Ended(with({"--print-config"}), folder / "large.toml").code, 0);
  EXPECT_THAT(contents_of(folder / "large.toml"), HasSubstr("# max-working = ")) << "said, not asked for";
  const Ended small({"--config", folder / "large.toml", "--memory", std::to_string(least_memory()) + "MiB",
                     "--print-config"},
                    folder / "small.toml");
  EXPECT_EQ(small.code, 0) << small.said;
}

}  // namespace
}  // namespace fracture::test
