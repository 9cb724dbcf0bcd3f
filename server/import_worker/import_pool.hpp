// Imports in other processes: a pool of sandboxed fracture-import children (worker_process.hpp), because the
// readers of foreign formats crash, leak and run away on hostile files. A worker that dies costs one request
// a typed error and is replaced.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/import_worker/worker_process.hpp"

namespace fracture {

struct ImportPoolConfig {
  WorkerProcessConfig worker;
  int workers = 1;
  /// A worker is replaced after so many imports, or when it holds so much memory: what its readers leak or
  /// fragment goes with it.
  std::uint32_t max_imports = 500;
  std::uint64_t max_resident_bytes = 128ull << 20;
};

/// Since the start; each import is counted once under how it ended.
struct ImportCounters {
  std::uint64_t imported = 0;     ///< meshes
  std::uint64_t refused = 0;      ///< typed errors of the readers
  std::uint64_t crashed = 0;      ///< the worker died of the file
  std::uint64_t limited = 0;      ///< over the limit of memory, processor time or output
  std::uint64_t interrupted = 0;  ///< given up in mid-import: deadline or cancel, the worker was killed
  std::uint64_t started = 0;      ///< worker processes
  std::uint64_t recycled = 0;     ///< of them replaced in good health
  int workers = 0;                ///< alive now
  int starting = 0;               ///< not alive yet, or waiting for their start
  int busy = 0;                   ///< of them importing
};

class ImportPool {
 public:
  /// Starts one worker and waits for it; the others start when they are needed. Throws what WorkerProcess
  /// throws.
  explicit ImportPool(ImportPoolConfig config);
  ~ImportPool();
  ImportPool(const ImportPool&) = delete;
  ImportPool& operator=(const ImportPool&) = delete;

  /// As import_mesh(); waits for a free worker. What the worker may take is set aside in the execution's
  /// allowance before: little at first, by the size of the file, and more where that was too little (an
  /// instanced or compressed file), up to the worker's own limit. Further errors: kImporterCrashed,
  /// kImporterLimit. Throws Interrupted; std::runtime_error where no worker can be started any more.
  /// Thread-safe.
  Expected<Mesh> import(std::span<const std::byte> mesh, MeshFormat format, std::span<const ImportFile> files,
                        const ImportLimits& limits, const Execution& execution);

  ImportCounters counters() const;
  /// Of the first worker: what of the sandbox this machine allows.
  WorkerHello hello() const;
  std::vector<pid_t> pids() const;

 private:
  void supervise();
  /// `last`: it is not tried again with more.
  Expected<Mesh> import_within(std::uint64_t memory_bytes, bool last, std::span<const std::byte> mesh,
                               MeshFormat format, std::span<const ImportFile> files,
                               const ImportLimits& limits, const Execution& execution);
  std::unique_ptr<WorkerProcess> take(const Execution& execution);
  void give_back(std::unique_ptr<WorkerProcess> worker, bool healthy);

  const ImportPoolConfig config_;
  mutable std::mutex mutex_;
  std::condition_variable supervisor_, free_;
  std::vector<std::unique_ptr<WorkerProcess>> idle_, retired_;
  std::vector<pid_t> busy_;
  int to_start_ = 1;  ///< wanted and not yet begun
  int starting_ = 0;
  int waiting_ = 0;  ///< imports without a worker
  std::uint64_t failed_starts_ = 0;
  std::string start_error_;
  WorkerHello hello_;
  ImportCounters counters_;
  bool stopping_ = false;
  std::thread thread_;  ///< starts and buries workers: they die with the thread that started them
};

/// fracture-import beside the running program; nothing where it is not there.
std::string import_worker_beside_this_program();

}  // namespace fracture
