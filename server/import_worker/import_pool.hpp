// Imports in other processes: a pool of sandboxed fracture-import children (worker_process.hpp), because the
// readers of foreign formats crash, leak, run away and may be taken over by hostile files. A worker reads one
// file and ends, the next one has been forked meanwhile; only where all files are the caller's own it reads
// several. A worker that dies of its file costs one request a typed error, and the same file the same error
// at once from then on.
//
// A file may be read for a minute. So imports take turns: whoever waits has its turn after those who read have had theirs
// (kTurn), urgent work at once. A process whose turn it is not is stopped (SIGSTOP), and goes on later; so is that of a
// computation that should stand still for another one's (service/worker_pool.hpp).
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/import_worker/import_memo.hpp"
#include "server/import_worker/worker_process.hpp"

namespace fracture {

struct ImportPoolConfig {
  WorkerProcessConfig worker;
  int workers = 1;  ///< that read at the same time
  /// The zygote is started anew after so many forks, and after every crash: its forks share the places of
  /// everything in memory, and nobody is to find them out by trying.
  std::uint32_t max_forks = 500;
  /// More than 1 only for files of one owner: who takes a reader over reads and answers what comes after.
  int files_per_worker = 1;
};

/// Since the start; each import is counted once under how it ended.
struct ImportCounters {
  std::uint64_t imported = 0;  ///< meshes
  std::uint64_t refused = 0;   ///< typed errors of the readers
  std::uint64_t crashed = 0;   ///< the worker died of the file
  std::uint64_t limited = 0;   ///< over the limit of memory, processor time or output
  std::uint64_t no_room = 0;   ///< the machine had no memory, descriptor or process for it: never remembered
  std::uint64_t interrupted = 0;  ///< given up in mid-import: deadline or cancel, the worker was killed
  std::uint64_t remembered = 0;   ///< refused by what is known of the file, without a worker
  std::uint64_t started = 0;      ///< worker processes
  std::uint64_t zygotes = 0;      ///< processes started to fork them
  int workers = 0;                ///< alive now
  int starting = 0;               ///< not alive yet, or waiting for their start
  int busy = 0;                   ///< of them importing
  int standing = 0;               ///< of them stopped in mid-import, for others
};

class ImportPool {
 public:
  /// Starts one worker and waits for it; the others start when they are needed. Throws what WorkerProcess
  /// throws.
  explicit ImportPool(ImportPoolConfig config);
  ~ImportPool();
  ImportPool(const ImportPool&) = delete;
  ImportPool& operator=(const ImportPool&) = delete;

  /// Asked on the thread of an import: should its computation stand still?
  using StandsBack = std::function<bool()>;
  /// As import_mesh(); waits for its turn, urgent work (Turn::is_urgent, asked again while it waits) before other
  /// work. What the worker may take is set aside in the
  /// execution's allowance before: little at first, by the size of the file, and more where that was too
  /// little (an instanced or compressed file), up to the worker's own limit. A worker that somebody else
  /// killed (the kernel short of memory, an operator) says nothing about its file, which is read once more by
  /// another one. Further errors: kImporterCrashed, kImporterLimit; kOverloaded where this machine has no room for a
  /// reader now, which says nothing about the file and is never remembered. Throws Interrupted.
  /// `digest`: what the caller knows the input by, 64 hex digits, another one for each input. An input that
  /// once killed its reader, or needed more than an import may have, gets the same error at once; one that
  /// was computed on for longer than there is time until the deadline, its Interrupted. Thread-safe.
  Expected<Mesh> import(std::span<const std::byte> mesh, MeshFormat format, std::span<const ImportFile> files,
                        const ImportLimits& limits, const Execution& execution, std::string_view digest,
                        const StandsBack& stands_back = {});

  /// For so long an import reads while others wait.
  static constexpr std::chrono::milliseconds kTurn{50};

  ImportCounters counters() const;
  /// Of the first worker and its zygote: what of the sandbox this machine allows.
  WorkerHello hello() const;
  ZygoteHello zygote_hello() const;
  /// Of the workers, those that are reading first.
  std::vector<pid_t> pids() const;
  /// -1 while there is none.
  pid_t zygote_pid() const;

 private:
  void supervise();
  /// What is asked for, and what the memo calls it.
  struct Input {
    std::span<const std::byte> mesh;
    MeshFormat format;
    std::span<const ImportFile> files;
    std::string digest, name;
    const StandsBack& stands_back;
  };
  /// One worker's reading of an input.
  struct Try {
    std::uint64_t memory_bytes = 0;
    bool last = false;               ///< there is no more memory to try it with
    bool was_killed_before = false;  ///< from outside, in a try before: not again for that
    bool was_killed = false;         ///< how this one ended
  };
  /// Nothing: it is to be tried again.
  std::optional<Expected<Mesh>> import_within(Try& attempt, const Input& input, const ImportLimits& limits,
                                              const Execution& execution);
  std::unique_ptr<WorkerProcess> fork_worker();
  std::unique_ptr<WorkerProcess> first_worker_of_a_new_zygote();
  void want_a_spare();
  /// The turn of an import, from its wait for a worker to its end.
  struct Place final : Turn {
    Place(ImportPool& its_pool, const Execution& its_execution, const StandsBack& its_stands_back)
        : pool(its_pool), execution(its_execution), stands_back(its_stands_back) {}
    void give_way() override;
    void leave() override {}
    void come_back() override {}
    bool is_urgent() const override { return !execution.turn || execution.turn->is_urgent(); }
    /// Tells the computation what the worker has used since it was told before.
    void tell_of_use();

    ImportPool& pool;
    const Execution& execution;
    const StandsBack& stands_back;
    WorkerProcess* worker = nullptr;
    std::chrono::steady_clock::time_point since{};  ///< it reads
    std::chrono::nanoseconds told{0};
  };
  struct Waiting;
  struct Standing;
  std::unique_ptr<WorkerProcess> take(Place& place);
  /// In mid-import, until it is its turn again; `back`: after its computation has stood still.
  void stand_still(Place& place, bool back);
  // With the lock.
  bool is_next(const Place& place) const;
  bool is_others_turn(const Place& place) const;
  int reading_or_starting() const;
  void bury(std::unique_ptr<WorkerProcess> worker);
  void keep(std::unique_ptr<WorkerProcess> worker);

  const ImportPoolConfig config_;
  ImportMemo memo_;
  mutable std::mutex mutex_;
  std::condition_variable supervisor_, free_;
  std::vector<std::unique_ptr<WorkerProcess>> idle_, retired_;
  std::list<Place*> line_;  ///< who waits to read, the longest first
  std::vector<pid_t> busy_;
  int to_start_ = 1;  ///< wanted and not yet begun
  int starting_ = 0;
  std::uint64_t failed_starts_ = 0;
  std::string start_error_;
  WorkerHello hello_;
  ZygoteHello zygote_hello_;
  pid_t zygote_pid_ = -1;
  bool renew_zygote_ = false;
  ImportCounters counters_;
  bool stopping_ = false;
  std::unique_ptr<ZygoteProcess> zygote_;  ///< the supervisor's own
  std::thread thread_;  ///< starts and buries processes: they die with the thread that started them
};

/// fracture-import beside the running program. Throws std::runtime_error where it is not there.
std::string import_worker_beside_this_program();

}  // namespace fracture
