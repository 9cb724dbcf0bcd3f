// The cache tiers below memory, for results: this server's disk (L1), then a Redis that several servers share (L2).
// Reads block, so they run on a pool thread. Writing happens after the answer, on a separate thread, and clients take turns
// (fair_queue.hpp). If writing cannot keep up, results are dropped, because a cache may always miss. The client that
// holds the most loses its newest result, as the longest queue does in McKenney 1990 ("Stochastic fairness queueing",
// INFOCOM). Each client keeps its first result. A client that holds less loses results only for another client's first one.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "common/base/execution.hpp"
#include "server/cache/disk_cache.hpp"
#include "server/cache/redis_cache.hpp"
#include "server/service/fair_queue.hpp"
#include "server/service/result.hpp"

namespace fracture {

struct TiersConfig {
  std::string folder;  ///< folder of the disk tier; empty: no disk tier
  std::uint64_t disk_bytes = 4ull << 30;
  RedisConfig redis;       ///< no Redis tier if the address is empty; ResultTiers sets its keys and algorithm
  FarmKeys keys;           ///< sign entries written to Redis, and verify entries read from it
  bool sign_disk = false;  ///< also sign and verify entries on the disk with these keys
  std::size_t max_pending_bytes = 64u
                                  << 20;  ///< limit on results that wait for the one that is being written
};

struct TiersFigures {
  std::optional<DiskFigures> disk;  ///< empty: there is no such tier
  std::optional<RedisFigures> redis;
  bool disk_unusable = false;  ///< a folder is configured but cannot be used
  std::uint64_t dropped = 0;   ///< results that were not written because too many waited or memory was short
};

/// Thread-safe.
class ResultTiers {
 public:
  explicit ResultTiers(const TiersConfig& config);
  /// Keeps writing pending results for at most a second, then drops the rest.
  ~ResultTiers();
  ResultTiers(const ResultTiers&) = delete;
  ResultTiers& operator=(const ResultTiers&) = delete;

  /// Returns whether any tier exists.
  bool any() const { return disk_ || redis_; }
  /// kFileAccess if a disk tier is configured but could not be used at startup.
  const std::optional<Error>& disk_unusable() const { return disk_unusable_; }
  /// Returns whether another server has the folder of the disk tier. Until take_folder() gets the folder, that tier misses.
  bool waits_for_folder() const { return disk_ && !disk_->held(); }
  /// Takes the folder if the other server has released it; returns false if it has not. Must not be called by several
  /// threads at the same time.
  Expected<bool> take_folder() { return disk_ ? disk_->take() : true; }

  /// Returns the expected size of this key's entry in bytes; nothing if no tier can have one.
  std::optional<std::uint64_t> expected_bytes(const std::string& key) const;

  struct Found {
    std::shared_ptr<const FractureResult> result;  ///< null: not found
    CacheOutcome disk = CacheOutcome::kNotConsulted, redis = CacheOutcome::kNotConsulted;
    bool no_room = false;  ///< an entry exists, but was not read because memory is short
  };
  /// Looks for a result in all tiers. Blocks. A result found in Redis is also written to the disk, at this client's turn
  /// (Flow::name). Before an entry is read, `room` decides whether that many bytes may be held; an empty function always
  /// allows it.
  Found find(const std::string& key, const Room& room = {}, const Execution& execution = kUninterrupted,
             const std::string& client = {});
  /// Queues the result to be written at this client's turn (Flow::name), and returns at once.
  void store(std::shared_ptr<const FractureResult> result, const std::string& client = {});
  /// Blocks until all pending results are written, at most until that time.
  void flush(std::chrono::steady_clock::time_point until = std::chrono::steady_clock::time_point::max());
  /// Returns whether the disk has an entry for this key.
  bool on_disk(const std::string& key) const { return disk_ && disk_->size_of(key).has_value(); }
  /// Makes sure that the result is on the disk, whichever thread writes it. Blocks, but not for results that wait to be
  /// written. Returns false without a disk tier, if the tier is full, or if the system reports an error.
  bool keep_on_disk(const std::shared_ptr<const FractureResult>& result);
  /// Returns the size of this key's entry on the disk, or 0 if the disk lacks it.
  std::uint64_t bytes_on_disk(const std::string& key) const {
    return disk_ ? disk_->size_of(key).value_or(0) : 0;
  }
  /// Protects the disk's entry for this key from eviction (DiskCache::pin). A call of unpin() must follow.
  void pin(const std::string& key) {
    if (disk_) disk_->pin(key);
  }
  void unpin(const std::string& key) {
    if (disk_) disk_->unpin(key);
  }
  std::uint64_t most_pinned() const { return disk_ ? disk_->most_pinned() : 0; }
  /// While this is on, the disk evicts nothing (DiskCache::keep_all).
  void keep_all_on_disk(bool keep) {
    if (disk_) disk_->keep_all(keep);
  }

  TiersFigures figures() const;

 private:
  struct Pending {  ///< see FairQueue
    std::uint64_t id;
    double cost;
    Flow flow;
    std::chrono::steady_clock::time_point arrival;
    std::shared_ptr<const FractureResult> result;
    bool to_redis;
  };
  using Queue = FairQueue<Pending>;

  void enqueue(std::shared_ptr<const FractureResult> result, bool to_redis, const std::string& client);
  /// Drops waiting results of other clients until a result of this client with this many bytes fits. Returns false, and
  /// drops nothing, if that is impossible. Other clients keep their first results. They lose others only while they hold
  /// more than this client would, unless this is its first. Requires the lock.
  bool make_room(const std::string& client, std::size_t bytes);
  void write_pending();
  void write(const Pending& pending);
  /// Writes the entry unless it is there. Waits while another thread writes it. Returns whether it is there.
  bool write_to_disk(const CacheEntry& entry);

  std::optional<Error> disk_unusable_;
  std::unique_ptr<DiskCache> disk_;
  std::unique_ptr<RedisCache> redis_;
  const std::size_t max_pending_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable wake_, written_;
  Queue pending_;
  std::size_t pending_bytes_ = 0;
  std::uint64_t next_ = 0, dropped_ = 0;
  bool stopping_ = false;
  std::optional<std::string> writes_for_;  ///< client whose result is being written
  std::set<std::string> to_disk_;          ///< keys that are being written to the disk
  std::thread writer_;
};

}  // namespace fracture
