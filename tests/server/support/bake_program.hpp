// bake as its user runs it, in a folder with some meshes.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/server/support/bake_folder.hpp"
#include "tests/server/support/child_process.hpp"

namespace fracture::test {

struct BakeProgram : testing::Test {
  TemporaryFolder folder;
  std::string out, err;  ///< of the last command

  void SetUp() override {
    write_meshes(folder, 3);
    folder.write(
        "cube.off",
        "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 "
        "4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n");
    // A box with five of its six sides. It is repaired, which causes a warning.
    folder.write(
        "tub.off",
        "OFF\n8 5 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 "
        "4\n4 1 2 6 5\n4 2 3 7 6\n");
  }
  /// Runs a shell command in the folder; `$f` is the program.
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
      count +=
          fs::is_regular_file(entry.symlink_status()) && !entry.path().filename().string().starts_with(".");
    return count;
  }
};

}  // namespace fracture::test
