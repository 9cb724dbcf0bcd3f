// bake as its user meets it: pipes, misspelt words, places that are refused, what it says, and how it ends.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>

#include "common/base/digest.hpp"
#include "server/bake/plan.hpp"
#include "server/service/failure_keeper.hpp"
#include "tests/server/bake_folder.hpp"
#include "tests/server/child_process.hpp"
#include "tests/server/door.hpp"
#include "tests/server/server_process.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

struct BakeProgram : testing::Test {
  TemporaryFolder folder;
  std::string out, err;  ///< of the last command

  void SetUp() override {
    write_meshes(folder, 3);
    folder.write(
        "cube.off",
        "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 "
        "4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n");
    // Five of its six sides: it is mended, which is worth a warning.
    folder.write(
        "tub.off",
        "OFF\n8 5 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 "
        "4\n4 1 2 6 5\n4 2 3 7 6\n");
  }
  /// In the folder; `$f` is the program.
  int shell(const std::string& command) {
    ChildProcess child({"/bin/sh", "-c",
                        "cd '" + folder.path + "' || exit 99; f='" FRACTURE_SERVER_PROGRAM "'; { " + command +
                            "\n} >.out 2>.err </dev/null"},
                       folder / ".log");
    const int code = child.wait();
    out = read_file(folder / ".out");
    err = read_file(folder / ".err");
    return code;
  }
  std::string bytes(const std::string& name) const { return read_file(folder / name); }
  std::size_t files(const std::string& below = "") const {
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder / below))
      count += entry.is_regular_file() && !entry.path().filename().string().starts_with(".");
    return count;
  }
};

TEST_F(BakeProgram, ParametersMayBeWrittenWithDashes) {
  ASSERT_EQ(shell("$f bake cube.off -q -o a.glb --max_fragments 5 --interior_name Core"), 0) << err;
  ASSERT_EQ(shell("$f bake cube.off -q -o b.glb --max-fragments=5 --interior-name Core"), 0) << err;
  EXPECT_EQ(bytes("a.glb"), bytes("b.glb"));
  EXPECT_EQ(shell("$f bake cube.off -q -o c.glb --max-fragments=5 --max_fragments 6"), 2) << "given twice";
  ASSERT_EQ(shell("$f inspect tub.off --weld-tolerance=0.001"), 1) << err;
  ASSERT_EQ(shell("$f bake --help"), 0);
  EXPECT_THAT(out, AllOf(HasSubstr("--max-fragments"), Not(HasSubstr("--max_fragments"))));
}

TEST_F(BakeProgram, AMisspeltWordIsAnsweredWithTheNearest) {
  const struct {
    std::string command, said;
    int code;
  } cases[] = {
      {"bake cube.off -o x.glb --max-fragmnets 5",
       "there is no option --max-fragmnets; did you mean --max-fragments?", 2},
      {"bake cube.off -o x.glb --max_fragmnets=5",
       "there is no option --max_fragmnets; did you mean --max-fragments?", 2},
      {"bake cube.off -o x.glb --mainfest m", "did you mean --manifest?", 2},
      {"bake cube.off --ouput x.glb", "did you mean --output?", 2},
      {"bake cube.off -o x.glb --colour red", "there is no option --colour\n", 2},
      {"inspect --thikness=5", "did you mean --thickness?", 3},
      {"serve --max-boddy 5", "did you mean --max-body?", 2},
      {"serve --max_body 5", "did you mean --max-body?", 2},
      {"serve --prot 5", "did you mean --port?", 2},
      {"health --redy", "did you mean --ready?", 1},
      {"bkae cube.off -o x.glb", "there is no command 'bkae'; did you mean bake?", 2},
      {"inpsect cube.off", "did you mean inspect?", 2},
      {"cube.off", "there is no command 'cube.off': there are serve, bake, inspect, health", 2},
      {"--verison", "did you mean --version?", 2},
      {"--sites 5 bake cube.off -o x.glb", "there is no option --sites before the command bake", 2},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(shell("$f " + c.command), c.code) << c.command;
    EXPECT_THAT(err, HasSubstr(c.said)) << c.command;
    EXPECT_EQ(out, "") << c.command;
  }
  EXPECT_FALSE(fs::exists(folder / "x.glb"));
}

TEST_F(BakeProgram, TakesMemoryInBytesAndNothingElse) {
  EXPECT_EQ(shell("$f bake cube.off -o x.glb -q --memory 512MiB"), 0) << err;
  for (const char* wrong : {"5", "5GB", "-1", "lots", "1.5GiB"}) {
    EXPECT_EQ(shell("$f bake cube.off -o x.glb -q --memory=" + std::string(wrong)), 2) << wrong;
    EXPECT_THAT(err, AllOf(HasSubstr("--memory"), HasSubstr(wrong)));
  }
}

}  // namespace
}  // namespace fracture::test
