// Other programs as children of a test: they die with the test, and are killed when their object is
// destroyed.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/server/support/temporary_folder.hpp"

namespace fracture::test {

/// Full path of a program in PATH or in Debian's folders for servers; nothing if it is not installed.
std::optional<std::string> find_program(const std::string& name);

/// A port of 127.0.0.1 that was free a moment ago.
std::uint16_t free_port();

std::string read_file(const std::string& path);

class ChildProcess {
 public:
  /// Standard output and standard error go to the file `output`.
  ChildProcess(std::vector<std::string> arguments, const std::string& output);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void signal(int number);
  pid_t pid() const { return pid_; }
  bool alive();
  /// Returns the exit code, or 1000 + the signal that killed it.
  int wait();

 private:
  pid_t pid_ = 0;
  int status_ = 0;
  bool ended_ = false;
};

}  // namespace fracture::test
