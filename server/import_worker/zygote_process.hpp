// The zygote as the server sees it: one started fracture-import that never reads a file and forks a worker
// for each one.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "server/import_worker/protocol.hpp"
#include "server/import_worker/shared_memory.hpp"

namespace fracture {

struct WorkerProcessConfig {
  std::string program;  ///< path of fracture-import
  /// Address space that a worker may take beyond what it begins with; 0: no limit.
  std::uint64_t memory_bytes = 2ull << 30;
  std::chrono::seconds cpu{60};  ///< processor time of one import; 0: no limit
  bool require_sandbox = false;  ///< a worker without a seccomp filter is an error
};

/// A zygote and its forks are one group of processes. When the last of them that the server knows is gone, so
/// is every other one: a fork that the zygote ended too early to tell of is a child of the server, too, and
/// nobody else would ever reap it.
class ProcessGroup {
 public:
  explicit ProcessGroup(pid_t leader) : leader_(leader) {}
  ~ProcessGroup();
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;

 private:
  const pid_t leader_;
};

/// To be used from one thread, which outlives it and everything forked: they die with that thread.
class ZygoteProcess {
 public:
  /// Starts the program and waits for its hello. Throws std::system_error or std::runtime_error with the path
  /// and the reason.
  explicit ZygoteProcess(const WorkerProcessConfig& config);
  /// Kills and reaps. What it has forked lives on.
  ~ZygoteProcess();
  ZygoteProcess(const ZygoteProcess&) = delete;
  ZygoteProcess& operator=(const ZygoteProcess&) = delete;

  struct Forked {
    pid_t pid = -1;  ///< a child of this process, to be reaped here
    Descriptor socket;
    std::shared_ptr<ProcessGroup> group;  ///< to be let go when it has been
  };
  /// Throws std::system_error or std::runtime_error; then the zygote is of no more use.
  Forked fork();

  pid_t pid() const { return pid_; }
  const ZygoteHello& hello() const { return hello_; }
  std::uint32_t forks() const { return forks_; }

 private:
  void start(const WorkerProcessConfig& config);
  void kill_and_reap();

  pid_t pid_ = -1;
  std::shared_ptr<ProcessGroup> group_;
  Descriptor socket_;
  ZygoteHello hello_;
  std::uint32_t forks_ = 0;
};

/// Receives a message within the time that a process may take to start. False: it did not say it.
bool receive_in_time(int socket, void* message, std::size_t size);

}  // namespace fracture
