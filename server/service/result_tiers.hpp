// The tiers below memory, for results: the disk of this server (L1), then a Redis that servers share (L2).
// Reading blocks, on a thread of the pool; writing happens behind the answer, on a thread of its own, and is
// given up when it cannot keep up: a cache may always miss.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/base/execution.hpp"
#include "server/cache/disk_cache.hpp"
#include "server/cache/redis_cache.hpp"
#include "server/service/result.hpp"

namespace fracture {

struct TiersConfig {
  std::string folder;  ///< of the disk tier; empty: none
  std::uint64_t disk_bytes = 4ull << 30;
  RedisConfig redis;       ///< without an address: none; its keys and algorithm are set here
  FarmKeys keys;           ///< sign what goes to Redis, and are asked for of what comes from there
  bool sign_disk = false;  ///< with the keys: the same of the disk
  std::size_t max_pending_bytes = 64u << 20;  ///< of results that wait to be written
};

struct TiersFigures {
  std::optional<DiskFigures> disk;  ///< nothing: there is no such tier
  std::optional<RedisFigures> redis;
  bool disk_unusable = false;  ///< a folder is configured, and cannot be used
  std::uint64_t dropped = 0;   ///< results that were not written because too many waited
};

/// Thread-safe.
class ResultTiers {
 public:
  explicit ResultTiers(const TiersConfig& config);
  /// Writes what is still pending, for a second at most.
  ~ResultTiers();
  ResultTiers(const ResultTiers&) = delete;
  ResultTiers& operator=(const ResultTiers&) = delete;

  /// Is there any tier to ask?
  bool any() const { return disk_ || redis_; }
  /// kFileAccess when there is to be a disk tier and it could not be used at the start.
  const std::optional<Error>& disk_unusable() const { return disk_unusable_; }
  /// Another server has the folder of the disk tier. Until take_folder() gets it, that tier misses.
  bool waits_for_folder() const { return disk_ && !disk_->held(); }
  /// Takes the folder when the other server has let it go. False while it has not. By one thread at a time.
  Expected<bool> take_folder() { return disk_ ? disk_->take() : true; }

  /// What reading the entry of this key should take, in bytes; nothing where it is known that there is none.
  std::optional<std::uint64_t> expected_bytes(const std::string& key) const;

  struct Found {
    std::shared_ptr<const FractureResult> result;  ///< null: nowhere
    CacheOutcome disk = CacheOutcome::kNotConsulted, redis = CacheOutcome::kNotConsulted;
    bool no_room = false;  ///< it is there, and was not read for lack of memory
  };
  /// Blocks. What Redis had is written to the disk too. `room` is asked before an entry is read whether so
  /// many bytes may be held meanwhile; empty: always.
  Found find(const std::string& key, const Room& room = {}, const Execution& execution = kUninterrupted);
  /// Returns at once.
  void store(std::shared_ptr<const FractureResult> result);
  /// Returns when nothing is pending, or at that time.
  void flush(std::chrono::steady_clock::time_point until = std::chrono::steady_clock::time_point::max());
  /// Is there an entry on the disk?
  bool on_disk(const std::string& key) const { return disk_ && disk_->size_of(key).has_value(); }
  /// Returns when the result is on the disk, written by whoever. False when it cannot be: no such tier, no
  /// room, or the system refuses. Blocks.
  bool keep_on_disk(const std::shared_ptr<const FractureResult>& result);

  TiersFigures figures() const;

 private:
  void write_pending();

  std::optional<Error> disk_unusable_;
  std::unique_ptr<DiskCache> disk_;
  std::unique_ptr<RedisCache> redis_;
  const std::size_t max_pending_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable wake_, written_;
  struct Pending {
    std::shared_ptr<const FractureResult> result;
    bool to_redis;
  };
  void enqueue(Pending pending);
  std::deque<Pending> pending_;
  std::size_t pending_bytes_ = 0;
  std::uint64_t dropped_ = 0;
  bool stopping_ = false;
  std::string writing_;  ///< the key of what is being written; empty: nothing
  std::thread writer_;
};

}  // namespace fracture
