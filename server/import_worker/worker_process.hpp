// One import worker as the server sees it: a child process and the server's end of its socket.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <span>
#include <string>

#include "common/base/execution.hpp"
#include "server/import_worker/protocol.hpp"
#include "server/import_worker/shared_memory.hpp"

namespace fracture {

struct WorkerProcessConfig {
  std::string program;                      ///< path of fracture-import
  std::uint64_t memory_bytes = 2ull << 30;  ///< address space of a worker; 0: no limit
  std::chrono::seconds cpu{60};             ///< processor time of one import; 0: no limit
};

/// How an import ended where it did not end with an answer.
enum class WorkerDeath {
  kNone,
  kCrash,        ///< by a signal, an exit, or an answer that breaks a promise
  kCpuLimit,     ///< SIGXCPU
  kMemoryLimit,  ///< kLackedMemory
  kSizeLimit,    ///< SIGXFSZ: more output than a mesh may have
};

class WorkerProcess {
 public:
  /// Starts the program and waits for its hello. Throws std::system_error or std::runtime_error with the path
  /// and the reason. To be called from a thread that outlives the worker: it dies with that thread.
  explicit WorkerProcess(const WorkerProcessConfig& config);
  /// Kills and reaps.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// The worker's answer; `memory_bytes`: what it may take for it beyond what it has, 0: as much as the
  /// process may have. Throws Interrupted when the execution ends first; then, and where death() says so
  /// afterwards, the worker is of no more use.
  Expected<Mesh> import(std::span<const std::byte> mesh, MeshFormat format, std::span<const ImportFile> files,
                        const ImportLimits& limits, const Execution& execution,
                        std::uint64_t memory_bytes = 0);

  WorkerDeath death() const { return death_; }
  const std::string& last_words() const { return last_words_; }  ///< "signal 11 (Segmentation fault)"
  pid_t pid() const { return pid_; }
  const WorkerHello& hello() const { return hello_; }
  std::uint32_t imports() const { return imports_; }
  /// Resident memory now; 0 where /proc does not tell.
  std::uint64_t resident_bytes() const;

 private:
  void start(const WorkerProcessConfig& config);
  void allow_cpu() const;
  void allow_memory(std::uint64_t bytes) const;
  /// Waits for a message of the worker; false when it has died instead.
  bool wait_readable(const Execution& execution) const;
  Expected<Mesh> died(WorkerDeath how_at_least);
  void kill_and_reap();

  std::chrono::seconds cpu_;
  pid_t pid_ = -1;
  Descriptor socket_;
  WorkerHello hello_;
  std::uint32_t imports_ = 0;
  WorkerDeath death_ = WorkerDeath::kNone;
  std::string last_words_;
};

}  // namespace fracture
