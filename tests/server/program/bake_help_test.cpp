// The help of bake: its headings, and the values of each parameter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "common/parameters/groups.hpp"
#include "tests/server/support/bake_program.hpp"

namespace fracture::test {
namespace {

using testing::HasSubstr;

TEST_F(BakeProgram, TheHelpHasTheHeadingsOfTheDocumentsAndTheValuesOfEachParameter) {
  ASSERT_EQ(shell("$f bake --help"), 0);
  std::size_t at = 0;
  for (const ParameterGroup& group : parameter_groups()) {
    at = out.find("\nParameters: " + std::string(group.title) + ":\n", at);
    ASSERT_NE(at, std::string::npos) << group.title;
    for (const GroupedParameter& row : group.parameters) {
      std::string flag(row.name);
      std::replace(flag.begin(), flag.end(), '_', '-');
      EXPECT_NE(out.find("\n  --" + flag + " ", at), std::string::npos) << flag;
    }
  }
  for (const char* said : {"\nFiles:\n", "\nMany meshes:\n", "--repair fill|strict", "[default fill]",
                           "--growth X", "[a number from 1 to 10; default 1.35; only with radial]",
                           "-j,--jobs N", "[0 to 1024; default 0]", "sandstone or crystal"})
    EXPECT_THAT(out, HasSubstr(said));
  EXPECT_THAT(out, HasSubstr("default 0,-9.81,0"));
  std::istringstream lines(out);
  for (std::string line; std::getline(lines, line);)
    EXPECT_LE(line.size(), 110u) << line;  // 100 characters, some of more than one byte
}

}  // namespace
}  // namespace fracture::test
