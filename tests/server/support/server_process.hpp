// The program as a separate process, and a server process on free ports.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/server/support/server_program.hpp"
#include "tests/support/eventually.hpp"

extern char** environ;

namespace fracture::test {

class Process {
 public:
  /// Standard output goes to the file `output`.
  explicit Process(std::vector<std::string> arguments, const std::string& output = "/dev/null") {
    arguments.insert(arguments.begin(), server_program());
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 2);
    posix_spawn_file_actions_addopen(&actions, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (error != 0) throw std::runtime_error("cannot start " + arguments[0]);
    errors_ = ::fdopen(ends[0], "r");
  }
  ~Process() {
    if (!ended_) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    std::fclose(errors_);
  }
  std::string error_line() {
    std::string line;
    for (char part[1000]; std::fgets(part, sizeof part, errors_);)
      if ((line += part).back() == '\n') break;
    return line;
  }
  /// Returns the next line that contains `text` and skips warnings before it. Returns an empty line at the
  /// end, or if only other lines arrived for kPatience.
  std::string error_line_with(const std::string& text) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
      const std::string line = error_line();
      if (line.empty() || line.find(text) != std::string::npos) return line;
    }
    return {};
  }
  void signal(int number) { ::kill(pid_, number); }
  /// Returns the exit code, or 1000 + the signal that killed it.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  /// Sends SIGTERM, and another one after two seconds, which cancels the remaining computations. Returns the
  /// exit code as wait() does.
  int stop() {
    signal(SIGTERM);
    const auto ended = [this] {
      siginfo_t info{};
      return ::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
             info.si_pid != 0;
    };
    if (!eventually(std::chrono::seconds(2), "the server to end", ended)) signal(SIGTERM);
    return wait();
  }
  pid_t pid() const { return pid_; }
  bool alive() { return ::kill(pid_, 0) == 0 && ::waitpid(pid_, nullptr, WNOHANG) == 0; }

 private:
  pid_t pid_ = 0;
  FILE* errors_ = nullptr;
  bool ended_ = false;
};

/// `fracture-server serve` on free ports, which it names in its log.
class ServeProcess : public Process {
 public:
  explicit ServeProcess(std::vector<std::string> flags = {}) : Process(with_ports(std::move(flags))) {
    protect_the_machine_from(pid());
    const std::string line = error_line_with(" (admin port ");
    const std::size_t colon = line.rfind(':', line.find(" (admin port ")), admin = line.find("admin port ");
    if (colon == std::string::npos || admin == std::string::npos)
      throw std::runtime_error("the server ended before it listened");
    port = static_cast<std::uint16_t>(std::atoi(line.c_str() + colon + 1));
    admin_port = static_cast<std::uint16_t>(std::atoi(line.c_str() + admin + 11));
  }
  std::uint16_t port = 0, admin_port = 0;

 private:
  static std::vector<std::string> with_ports(std::vector<std::string> flags) {
    std::vector<std::string> all = {"serve", "--port", "0", "--admin-port", "0"};
    const auto unless_given = [&flags](const char* name, const char* value) {
      if (std::find(flags.begin(), flags.end(), name) == flags.end())
        flags.insert(flags.end(), {name, value});
    };
    unless_given("--threads", "2");
    unless_given("--drain-delay", "0");
    unless_given("--allow-host", "*");  // the clients of tests use any Host
    if (other_server_program()) flags = known_settings(flags);
    all.insert(all.end(), flags.begin(), flags.end());
    return all;
  }
};

}  // namespace fracture::test
