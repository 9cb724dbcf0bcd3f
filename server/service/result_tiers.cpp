#include "server/service/result_tiers.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/pipeline/algorithm_version.hpp"
#include "common/pipeline/fracture.hpp"
#include "server/service/kept_result.hpp"

namespace fracture {
namespace {

/// Memory holds the entry as it was read and, at the same time, the result that is made from it.
constexpr std::uint64_t kCopies = 2;

}  // namespace

ResultTiers::ResultTiers(const TiersConfig& config) : max_pending_bytes_(config.max_pending_bytes) {
  if (!config.folder.empty()) {
    disk_ = std::make_unique<DiskCache>(config.folder, config.disk_bytes,
                                        config.sign_disk ? config.keys : FarmKeys(), kAlgorithmVersion);
    disk_unusable_ = disk_->unusable();
    if (disk_unusable_) disk_.reset();
  }
  if (!config.redis.address.empty()) {
    RedisConfig redis = config.redis;
    redis.keys = config.keys;
    redis.algorithm = kAlgorithmVersion;
    redis_ = std::make_unique<RedisCache>(std::move(redis));
  }
  if (any()) writer_ = std::thread([this] { write_pending(); });
}

ResultTiers::~ResultTiers() {
  if (!writer_.joinable()) return;
  {
    std::unique_lock lock(mutex_);
    written_.wait_for(lock, std::chrono::seconds(1), [this] { return pending_.empty() && writing_.empty(); });
    pending_.clear();
    stopping_ = true;
  }
  written_.notify_all();
  wake_.notify_one();
  writer_.join();
}

std::optional<std::uint64_t> ResultTiers::expected_bytes(const std::string& key) const {
  // A typical answer for a game. Redis reports the size only together with the entry.
  constexpr std::uint64_t kUsual = 1u << 20;
  if (const auto size = disk_ ? disk_->size_of(key) : std::nullopt) return size;
  return redis_ ? std::optional(kUsual) : std::nullopt;
}

ResultTiers::Found ResultTiers::find(const std::string& key, const Room& room, const Execution& execution) {
  Found found;
  if (disk_) {
    const std::optional<std::uint64_t> size = disk_->size_of(key);
    found.no_room = size && room && !room(kCopies * *size);
    if (found.no_room) return found;
    found.disk = CacheOutcome::kMissNotStored;
    if (const auto stored = disk_->find(key)) {
      found.result = result_in(*stored, execution);
      if (!found.result) disk_->refuse(key);
    }
    if (found.result) {
      found.disk = CacheOutcome::kHit;
      return found;
    }
  }
  if (redis_) {
    found.redis = CacheOutcome::kMissNotStored;
    const Room room_for_it = [&](std::uint64_t bytes) {
      found.no_room = room && !room(kCopies * bytes);
      return !found.no_room;
    };
    if (const auto stored = redis_->find(key, room_for_it)) {
      found.result = result_in(*stored, execution);
      if (!found.result) redis_->refuse();
    }
    if (found.result) {
      found.redis = CacheOutcome::kHit;
      if (disk_) enqueue({found.result, false});
    }
  }
  return found;
}

void ResultTiers::store(std::shared_ptr<const FractureResult> result) {
  if (any()) enqueue({std::move(result), true});
}

void ResultTiers::enqueue(Pending pending) {
  {
    const std::lock_guard lock(mutex_);
    const std::size_t bytes = pending.result->file.size();
    if (pending_bytes_ + bytes > max_pending_bytes_) {
      ++dropped_;
      return;
    }
    pending_bytes_ += bytes;
    pending_.push_back(std::move(pending));
  }
  wake_.notify_one();
}

void ResultTiers::flush(std::chrono::steady_clock::time_point until) {
  const auto done = [this] { return pending_.empty() && writing_.empty(); };
  std::unique_lock lock(mutex_);
  if (until == std::chrono::steady_clock::time_point::max())
    written_.wait(lock, done);  // time_point::max() overflows in some implementations of wait_until
  else
    written_.wait_until(lock, until, done);
}

bool ResultTiers::keep_on_disk(const std::shared_ptr<const FractureResult>& result) {
  if (!disk_) return false;
  {
    // The writer thread may be writing it, or have it in its queue.
    std::unique_lock lock(mutex_);
    written_.wait(lock, [&] {
      return stopping_ || (writing_ != result->key &&
                           std::none_of(pending_.begin(), pending_.end(),
                                        [&](const Pending& p) { return p.result->key == result->key; }));
    });
  }
  if (on_disk(result->key)) return true;
  const std::string metadata = metadata_of(*result);
  return disk_->insert({result->key, metadata, result->file}) && on_disk(result->key);
}

void ResultTiers::write_pending() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stopping_ || !pending_.empty(); });
    if (stopping_) return;
    const Pending pending = std::move(pending_.front());
    pending_.pop_front();
    writing_ = pending.result->key;
    lock.unlock();
    const std::string metadata = metadata_of(*pending.result);
    const CacheEntry entry{pending.result->key, metadata, pending.result->file};
    if (disk_) disk_->insert(entry);
    if (redis_ && pending.to_redis) redis_->insert(entry);
    lock.lock();
    writing_.clear();
    pending_bytes_ -= pending.result->file.size();
    written_.notify_all();
  }
}

TiersFigures ResultTiers::figures() const {
  TiersFigures figures;
  if (disk_) figures.disk = disk_->figures();
  if (redis_) figures.redis = redis_->figures();
  figures.disk_unusable = disk_unusable_.has_value();
  const std::lock_guard lock(mutex_);
  figures.dropped = dropped_;
  return figures;
}

}  // namespace fracture
