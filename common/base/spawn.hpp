// Starting programs as child processes (POSIX).
#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <string>
#include <vector>

namespace fracture {

/// Describes a child process, and starts it. Without further calls, the child has the descriptors of this process that do not
/// close on exec, and its process group and signals.
class Spawn {
 public:
  Spawn();
  ~Spawn();
  Spawn(const Spawn&) = delete;
  Spawn& operator=(const Spawn&) = delete;

  // Descriptors are changed in the order of the calls.

  /// The child has our descriptor as its descriptor `theirs`. If both are the same number, it must not close on exec.
  void give(int ours, int theirs);
  /// The child opens a file as its descriptor `theirs`.
  void open(int theirs, const char* path, int flags);
  /// The child has no descriptors from this number on.
  void close_from(int first);

  /// The child leads a process group, so that its own children can be killed with it.
  void lead_group();
  /// The child leads a session, so that it gets no signals from our terminal.
  void lead_session();
  /// No signals are blocked or ignored in the child.
  void reset_signals();

  /// Starts the program with these arguments, of which the first one is its name. A program without a '/' is searched for in PATH.
  /// `variables`: its environment ("NAME=value"); null: the environment of this process. Sets `child` and returns 0, or returns
  /// the number of an error (errno).
  int start(const std::string& program, std::vector<std::string> arguments,
            const std::vector<std::string>* variables, pid_t& child) const;

 private:
  void add_flags(int more);

  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
  short flags_ = 0;
};

/// Waits for the end of a child process or, if the number is negative, of a child in this process group. A signal does not end the
/// wait.
void wait_for_end(pid_t child);

}  // namespace fracture
