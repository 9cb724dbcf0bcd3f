// The server's side of the zygote: a fracture-import process that never reads a file and only forks workers.
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
  /// Address space that a worker may take in addition to what it begins with, in bytes; 0: no limit.
  std::uint64_t memory_bytes = 2ull << 30;
  std::chrono::seconds cpu{60};  ///< limit on the processor time of a worker; 0: no limit
  bool require_sandbox = false;  ///< a worker without a seccomp filter is an error
};

/// The process group of a zygote and its forks. When the last process that the server knows has ended, the destructor ends
/// all others. If a zygote ends before it can report a fork, that fork is still a child of the server, and nobody else would
/// reap it.
class ProcessGroup {
 public:
  explicit ProcessGroup(pid_t leader) : leader_(leader) {}
  ~ProcessGroup();
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;

 private:
  const pid_t leader_;
};

/// Must be used from a single thread. That thread must outlive the zygote and all its forks, because they die with it.
class ZygoteProcess {
 public:
  /// Starts the program and waits for its hello. Throws std::system_error or std::runtime_error with the path and the reason.
  explicit ZygoteProcess(const WorkerProcessConfig& config);
  /// Kills and reaps the zygote. Its forks live on.
  ~ZygoteProcess();
  ZygoteProcess(const ZygoteProcess&) = delete;
  ZygoteProcess& operator=(const ZygoteProcess&) = delete;

  struct Forked {
    pid_t pid = -1;  ///< a child of this process, which must reap it
    Descriptor socket;
    std::shared_ptr<ProcessGroup> group;  ///< release it only after reaping the child
  };
  /// Forks a worker. Throws std::system_error or std::runtime_error; after that, the zygote must not be used any more.
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

/// Receives a message within the time that a process may take to start. Returns false if no valid message arrives.
bool receive_in_time(int socket, void* message, std::size_t size);

}  // namespace fracture
