// Imports in other processes: a pool of sandboxed fracture-import children (worker_process.hpp). Readers of foreign formats
// crash, leak, hang, and may be taken over by hostile files. A worker reads one file and ends, and by then the next worker
// has already been forked. A worker reads several files only if all of them belong to the caller. If a file kills its worker,
// one request gets a typed error, and from then on the same file gets this error at once.
//
// Reading a file may take a minute, so imports take turns. The client whose imports have read for the shortest time comes
// next (service/fair_queue.hpp), however many imports another client has in line. Among the imports of one client, a waiting
// one gets its turn after those that are reading have had theirs (kTurn), and an urgent one at once. A worker process is
// stopped (SIGSTOP) when its turn is over, and continues later. It is also stopped while its computation stands still for
// another one (service/worker_pool.hpp).
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
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
#include "server/service/fair_queue.hpp"

namespace fracture {

struct ImportPoolConfig {
  WorkerProcessConfig worker;
  int workers = 1;  ///< number of workers that read at the same time
  /// The zygote is restarted after this many forks, and after every crash. All forks of a zygote have the same memory layout,
  /// so this keeps an attacker from finding out the layout by trial and error.
  std::uint32_t max_forks = 500;
  /// Must be 1 unless all files have the same owner: a file that takes over a reader could read the files after it and forge
  /// their answers.
  int files_per_worker = 1;
  /// For error messages: what limits the memory of an import, and what to do if it is not enough.
  std::string memory_advice =
      "The limit is the smaller of --import-memory and half of the memory that one computation may use (--max-working). Send "
      "a smaller mesh, or raise these settings.";
};

/// Counters since the start. Each import counts once, by the way it ended.
struct ImportCounters {
  std::uint64_t imported = 0;     ///< imports that returned a mesh
  std::uint64_t refused = 0;      ///< imports that returned a reader's typed error
  std::uint64_t crashed = 0;      ///< imports whose file killed the worker
  std::uint64_t limited = 0;      ///< imports over the limit on memory, processor time or output
  std::uint64_t no_room = 0;      ///< the machine had no memory, descriptor or process; never remembered
  std::uint64_t interrupted = 0;  ///< imports that were cancelled or passed their deadline
  std::uint64_t remembered = 0;   ///< imports refused without a worker, because the file is known to fail
  std::uint64_t started = 0;      ///< worker processes that were started
  std::uint64_t zygotes = 0;      ///< processes that were started to fork workers
  int workers = 0;                ///< current number of workers
  int starting = 0;               ///< workers that are starting or waiting for their start
  int busy = 0;                   ///< workers that are importing
  int standing = 0;               ///< workers that are stopped in the middle of an import
};

class ImportPool {
 public:
  /// Starts one worker and waits for it. The others start when they are needed. Throws std::runtime_error if the worker
  /// cannot be started.
  explicit ImportPool(ImportPoolConfig config);
  ~ImportPool();
  ImportPool(const ImportPool&) = delete;
  ImportPool& operator=(const ImportPool&) = delete;

  /// Called on the thread of an import. Returns whether its computation should stand still.
  using StandsBack = std::function<bool()>;
  /// Imports a mesh like import_mesh(), in a worker. Thread-safe. Waits for the turn of the client (`flow`). Urgent
  /// imports (Turn::is_urgent, checked again during the wait) go before the client's others (FairQueue).
  ///
  /// The worker's memory is first set aside in the execution's allowance. The first try gets little memory, depending on the
  /// file's size. If that is not enough (an instanced or compressed file), further tries get more, up to the worker's limit.
  /// If a worker was killed from outside (by an operator, or by a kernel short of memory), the file is not to blame, and
  /// another worker reads it once more.
  ///
  /// `digest`: 64 hex digits by which the caller identifies the input, different for each input. If an input once killed its
  /// reader or exceeded an import's limits, it gets the same error at once. If an earlier try ran longer than the time left
  /// until the deadline, Interrupted is thrown at once.
  ///
  /// Further errors: kImporterCrashed, kImporterLimit. kOverloaded if this machine currently has no room for a reader; this is
  /// independent of the file and never remembered. Throws Interrupted.
  Expected<Mesh> import(std::span<const std::byte> mesh, MeshFormat format, std::span<const ImportFile> files,
                        const ImportLimits& limits, const Execution& execution, std::string_view digest,
                        const StandsBack& stands_back = {}, const Flow& flow = {});

  /// How long an import may read at a time while other imports of its client wait.
  static constexpr std::chrono::milliseconds kTurn{50};
  /// An import stops for one of another client if that client has used this much less time.
  static constexpr std::chrono::milliseconds kQuantum{20};

  ImportCounters counters() const;
  /// Return the hellos of the first worker and of the latest zygote. They say which parts of the sandbox this machine allows.
  WorkerHello hello() const;
  ZygoteHello zygote_hello() const;
  /// Returns the process ids of the workers. Workers that are reading come first.
  std::vector<pid_t> pids() const;
  /// Returns the zygote's process id; -1 if there is none.
  pid_t zygote_pid() const;

 private:
  void supervise();
  /// An input, and its name in the memo.
  struct Input {
    std::span<const std::byte> mesh;
    MeshFormat format;
    std::span<const ImportFile> files;
    std::string digest, name;
    const StandsBack& stands_back;
    const Flow& flow;
  };
  /// One try to read an input in a worker.
  struct Try {
    std::uint64_t memory_bytes = 0;
    bool last = false;               ///< no further try may have more memory
    bool was_killed_before = false;  ///< `was_killed` of an earlier try: repeated for this only once
    bool was_killed = false;         ///< this try failed for a reason that is not the file's fault
  };
  /// Runs one try. Returns nothing if the input must be tried again.
  std::optional<Expected<Mesh>> import_within(Try& attempt, const Input& input, const ImportLimits& limits,
                                              const Execution& execution);
  std::unique_ptr<WorkerProcess> fork_worker();
  std::unique_ptr<WorkerProcess> first_worker_of_a_new_zygote();
  void want_a_spare();
  struct Place;
  /// An import that waits to read.
  struct InLine {
    std::uint64_t id;
    double cost;
    Flow flow;
    std::chrono::steady_clock::time_point arrival;
    Place* place;
  };
  using Queue = FairQueue<InLine>;
  /// The turn of an import, from its wait for a worker to its end.
  struct Place final : Turn {
    Place(ImportPool& its_pool, const Execution& its_execution, const Input& its_input)
        : pool(its_pool), execution(its_execution), input(its_input) {}
    void give_way() override;
    void leave() override {}
    void come_back() override {}
    bool is_urgent() const override { return !execution.turn || execution.turn->is_urgent(); }
    Priority priority() const { return is_urgent() ? Priority::kRealtime : Priority::kBatch; }
    /// Reports the worker's processor time since the last report to the computation.
    void tell_of_use();

    ImportPool& pool;
    const Execution& execution;
    const Input& input;
    WorkerProcess* worker = nullptr;
    Queue::Client* client = nullptr;                  ///< null while it does not read
    std::chrono::steady_clock::time_point since{};    ///< begin of its current turn
    std::chrono::steady_clock::time_point charged{};  ///< its client was charged until then
    std::chrono::nanoseconds told{0};                 ///< processor time that was reported
  };
  struct Waiting;
  struct Standing;
  std::unique_ptr<WorkerProcess> take(Place& place);
  /// Stops an import in the middle, until it is its turn again. `back`: first lets its computation stand still.
  void stand_still(Place& place, bool back);
  // The following functions require the lock, except bury() and keep(), which take it.
  void begin(Place& place, const Queue::Next& next);
  /// Charges the client for the time since the last call. The time is that of the clock, because a worker that waits or
  /// sleeps also keeps others out.
  void charge(Place& place);
  void end(Place& place);
  void forget_clients();
  /// Returns whether an import that reads must stop for one in line.
  bool is_others_turn(const Place& place);
  int reading_or_starting() const;
  void bury(std::unique_ptr<WorkerProcess> worker);
  void keep(std::unique_ptr<WorkerProcess> worker);

  const ImportPoolConfig config_;
  ImportMemo memo_;
  mutable std::mutex mutex_;
  std::condition_variable supervisor_, free_;
  std::vector<std::unique_ptr<WorkerProcess>> idle_, retired_;
  Queue line_;  ///< imports that wait to read
  std::uint64_t next_in_line_ = 1;
  std::vector<Place*> reading_;
  std::vector<pid_t> busy_;
  int to_start_ = 1;  ///< workers to start whose start has not begun
  int starting_ = 0;
  std::uint64_t failed_starts_ = 0;
  std::string start_error_;
  WorkerHello hello_;
  ZygoteHello zygote_hello_;
  pid_t zygote_pid_ = -1;
  bool renew_zygote_ = false;
  ImportCounters counters_;
  bool stopping_ = false;
  std::unique_ptr<ZygoteProcess> zygote_;  ///< only the supervisor uses it
  std::thread thread_;  ///< the supervisor, which starts and reaps processes: they die with its thread
};

/// Returns the path of fracture-import in the running program's folder. Throws std::runtime_error if it does not exist.
std::string import_worker_beside_this_program();

}  // namespace fracture
