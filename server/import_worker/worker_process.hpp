// The server's side of an import worker: a fork of the zygote that reads files, and the server's end of its socket.
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

/// How an import ended, if it did not end with an answer.
enum class WorkerDeath {
  kNone,
  kCrash,        ///< a signal that the worker caused itself, an exit, or an invalid answer
  kKilled,       ///< a signal from outside (SIGKILL, SIGTERM); the file is not to blame
  kCpuLimit,     ///< SIGXCPU, or SIGKILL after the processor time is used up
  kMemoryLimit,  ///< kLackedMemory
  kSizeLimit,    ///< SIGXFSZ: more output than a mesh may have
  kNoRoom,       ///< kRefusedMemory: the system has no memory for it, whatever the file is
};

/// Returns a kOverloaded error with a time to retry, for an import that this machine currently has no room for.
Error no_room_to_read(const std::string& why);

class WorkerProcess {
 public:
  /// Forks a worker and waits for its hello from the sandbox. Throws the exceptions of ZygoteProcess::fork(), and
  /// std::runtime_error if the sandbox is required but not available.
  WorkerProcess(ZygoteProcess& zygote, const WorkerProcessConfig& config);
  /// Kills and reaps the process.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// Lets the worker read a file, and returns its answer. Must not be called again after a death or an exception. `digest`:
  /// the input's digest as 64 hex digits; an answer with another digest counts as a crash. `memory_bytes`: memory that the
  /// worker may take in addition to what it has; 0: up to the limit of the process. Throws Interrupted if the execution ends
  /// first.
  Expected<Mesh> import(std::span<const std::byte> mesh, MeshFormat format, std::span<const ImportFile> files,
                        std::string_view digest, const ImportLimits& limits, const Execution& execution,
                        std::uint64_t memory_bytes = 0);

  /// Stops the process, so that it uses no processor time until go_on().
  void stop() const;
  void go_on() const;

  WorkerDeath death() const { return death_; }
  /// Returns whether the worker got less address space than intended, because of `ulimit -v` or leftovers of earlier files.
  bool had_less() const { return had_less_; }
  int files() const { return files_; }                           ///< number of files that it got so far
  const std::string& last_words() const { return last_words_; }  ///< "signal 11 (Segmentation fault)"
  pid_t pid() const { return pid_; }
  const WorkerHello& hello() const { return hello_; }
  /// Returns the processor time that the worker has used so far, or until its end.
  std::chrono::nanoseconds processor_time() const;

 private:
  /// Limits the memory. Throws std::runtime_error if that is impossible.
  void allow_memory(std::uint64_t bytes);
  Expected<Mesh> died(WorkerDeath how_at_least);
  void kill_and_reap();

  std::chrono::seconds cpu_;
  std::uint64_t first_space_;  ///< bytes of address space right after the fork; 0: not known
  pid_t pid_ = -1;
  std::shared_ptr<ProcessGroup> group_;
  Descriptor socket_;
  WorkerHello hello_;
  WorkerDeath death_ = WorkerDeath::kNone;
  bool had_less_ = false;
  std::chrono::nanoseconds used_{0};  ///< processor time until its end
  std::string last_words_;
  int files_ = 0;
};

}  // namespace fracture
