// Standard output that cannot be written: every command that prints exits with 1 and gives the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/server/support/bake_program.hpp"
#include "tests/server/support/server_process.hpp"

namespace fracture::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(BakeProgram, OutputThatIsLostIsAnErrorOfEveryCommand) {
  const ServeProcess server;
  const std::string health = "health http://127.0.0.1:" + std::to_string(server.admin_port) + "/livez";
  // The output of some commands is longer than a buffer of stdio.
  for (const std::string& command :
       {std::string("--version"), std::string("--help"), std::string("bake --help"),
        std::string("serve --help"), std::string("serve --print-config"), std::string("inspect cube.off"),
        std::string("inspect cube.off --json"), std::string("inspect in/poison/sheet.obj"),
        std::string("inspect tub.off"), std::string("inspect cube.off tub.off"),
        std::string("inspect cube.off tub.off --json"), std::string("bake cube.off -o lost.glb --sites 5"),
        std::string("bake cube.off -o - --sites 5 -q"), std::string("bake cube.off -o x.glb --explain"),
        health}) {
    EXPECT_EQ(shell("$f " + command + " > /dev/full"), 1) << command;
    EXPECT_THAT(err, HasSubstr("cannot write to standard output: No space left on device\n")) << command;
    EXPECT_EQ(shell("$f " + command + " >&-"), 1) << command;
    EXPECT_THAT(err, HasSubstr("cannot write to standard output: Bad file descriptor\n")) << command;
    EXPECT_THAT(err, Not(HasSubstr("cannot write to standard output: No space"))) << command;
  }
  ASSERT_EQ(shell("$f bake cube.off -o right.glb --sites 5 -q"), 0) << err;
  EXPECT_EQ(bytes("lost.glb"), bytes("right.glb"))
      << "the file did not get the number and text of the stream";
}

TEST_F(BakeProgram, ACommandThatPrintsNothingNeedsNoStandardStreams) {
  EXPECT_EQ(shell("$f bake cube.off -o all.glb --sites 5 -q"), 0) << err;
  EXPECT_EQ(shell("$f bake cube.off -o none.glb --sites 5 -q <&- >&- 2>&-"), 0);
  EXPECT_EQ(bytes("none.glb"), bytes("all.glb"));
  EXPECT_EQ(shell("$f bake - -o x.glb --sites 5 <&-"), 1);
  EXPECT_THAT(err, HasSubstr("cannot read standard input: Bad file descriptor"));
}

}  // namespace
}  // namespace fracture::test
