// One import worker as the server sees it: a fork of the zygote that reads files, and the server's end of its
// socket.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/base/execution.hpp"
#include "common/mesh/mesh.hpp"
#include "server/import_worker/protocol.hpp"
#include "server/import_worker/shared_memory.hpp"
#include "server/import_worker/zygote_process.hpp"

namespace fracture {

/// How an import ended where it did not end with an answer.
enum class WorkerDeath {
  kNone,
  kCrash,        ///< by a signal of its own making, an exit, or an answer that breaks a promise
  kKilled,       ///< by a signal that comes from outside (SIGKILL, SIGTERM): nothing is said about the file
  kCpuLimit,     ///< SIGXCPU, or SIGKILL after as much time
  kMemoryLimit,  ///< kLackedMemory
  kSizeLimit,    ///< SIGXFSZ: more output than a mesh may have
  kNoRoom,       ///< kRefusedMemory: the system has none for it, whatever its file is
};

/// An import that this machine has no room for now, whatever its file is: kOverloaded, to be asked again soon.
Error no_room_to_read(const std::string& why);

class WorkerProcess {
 public:
  /// Forks and waits for its hello, in its sandbox. Throws what ZygoteProcess::fork() throws, and
  /// std::runtime_error where the sandbox is required and cannot be had.
  WorkerProcess(ZygoteProcess& zygote, const WorkerProcessConfig& config);
  /// Kills and reaps.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// The worker's answer; not to be called again after a death or an exception. `digest`: of the input, in 64 hex digits; an answer to any other
  /// is none. `memory_bytes`: what it may take for it beyond what it has, 0: as much as the process may have.
  /// Throws Interrupted when the execution ends first.
  Expected<Mesh> import(std::span<const std::byte> mesh, MeshFormat format, std::span<const ImportFile> files,
                        std::string_view digest, const ImportLimits& limits, const Execution& execution,
                        std::uint64_t memory_bytes = 0);

  /// It uses no processor from now on, until go_on().
  void stop() const;
  void go_on() const;

  WorkerDeath death() const { return death_; }
  /// The machine gave it less address space than it was to have (ulimit -v, or what earlier files left in it).
  bool had_less() const { return had_less_; }
  int files() const { return files_; }                           ///< that it was given so far
  const std::string& last_words() const { return last_words_; }  ///< "signal 11 (Segmentation fault)"
  pid_t pid() const { return pid_; }
  const WorkerHello& hello() const { return hello_; }
  /// Used so far, or until its end.
  std::chrono::nanoseconds processor_time() const;

 private:
  /// Throws std::runtime_error where it cannot be limited.
  void allow_memory(std::uint64_t bytes);
  Expected<Mesh> died(WorkerDeath how_at_least);
  void kill_and_reap();

  std::chrono::seconds cpu_;
  std::uint64_t first_space_;  ///< bytes of address space that it had when it was forked; 0: not known
  pid_t pid_ = -1;
  std::shared_ptr<ProcessGroup> group_;
  Descriptor socket_;
  WorkerHello hello_;
  WorkerDeath death_ = WorkerDeath::kNone;
  bool had_less_ = false;
  std::chrono::nanoseconds used_{0};  ///< until its end
  std::string last_words_;
  int files_ = 0;
};

}  // namespace fracture
