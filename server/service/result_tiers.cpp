#include "server/service/result_tiers.hpp"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include "common/pipeline/algorithm_version.hpp"
#include "common/pipeline/fracture.hpp"
#include "server/service/kept_result.hpp"

namespace fracture {
namespace {

/// Memory holds the entry as it was read and, at the same time, the result that is made from it.
constexpr std::uint64_t kCopies = 2;

constexpr Priority kClass = Priority::kBatch;  // only one class of the queue is used
/// Maximum number of clients whose use of the tiers is remembered after their results are written.
constexpr std::size_t kMostRemembered = 1024;

/// Returns the memory that a result takes while it waits.
std::size_t pending_bytes(const FractureResult& result) {
  constexpr std::size_t kClient = 4096;  // bytes of a client in the queue
  return kClient + result.parameters.size() + result.file.size();
}

/// Every waiting result may be written.
constexpr auto kAny = [](const auto&, Priority) { return true; };

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
    written_.wait_for(lock, std::chrono::seconds(1), [this] { return pending_.empty() && !writes_for_; });
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

ResultTiers::Found ResultTiers::find(const std::string& key, const Room& room, const Execution& execution,
                                     const std::string& client) {
  Found found;
  if (disk_) {
    const std::optional<std::uint64_t> size = disk_->size_of(key);
    found.no_room = size && room && !room(kCopies * *size);
    if (found.no_room) return found;
    found.disk = CacheOutcome::kMissNotStored;
    if (const auto stored = disk_->find(key, execution)) {
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
    if (const auto stored = redis_->find(key, room_for_it, execution)) {
      found.result = result_in(*stored, execution);
      if (!found.result) redis_->refuse();
    }
    if (found.result) {
      found.redis = CacheOutcome::kHit;
      if (disk_) enqueue(found.result, false, client);
    }
  }
  return found;
}

void ResultTiers::store(std::shared_ptr<const FractureResult> result, const std::string& client) {
  if (any()) enqueue(std::move(result), true, client);
}

void ResultTiers::enqueue(std::shared_ptr<const FractureResult> result, bool to_redis,
                          const std::string& client) {
  {
    const std::lock_guard lock(mutex_);
    const std::size_t bytes = pending_bytes(*result);
    if (!make_room(client, bytes)) {
      ++dropped_;
      return;
    }
    pending_.push(
        kClass,
        {next_++, 0, {.name = client}, std::chrono::steady_clock::now(), std::move(result), to_redis});
    pending_bytes_ += bytes;
  }
  wake_.notify_one();
}

bool ResultTiers::make_room(const std::string& client, std::size_t bytes) {
  if (pending_bytes_ + bytes <= max_pending_bytes_) return true;
  struct Holder {
    Queue::Next first;
    std::size_t held, keeps;
    std::size_t excess() const { return held > keeps ? held : 0; }
  };
  std::vector<Holder> others;
  std::size_t own = 0;
  for (const Queue::Next& first : pending_.candidates(kAny)) {
    std::size_t held = 0;
    for (const Pending& pending : first.client->line(kClass).queue) held += pending_bytes(*pending.result);
    if (first.client->name == client)
      own = held;
    else
      others.push_back({first, held, pending_bytes(*first.item().result)});
  }
  // Every other client keeps its first result. If this result is not its client's first one, the others also keep as much
  // as this client would hold.
  const bool is_first = own == 0 && writes_for_ != client;
  std::size_t least = own + bytes;
  for (Holder& other : others) {
    if (!is_first) other.keeps = std::max(other.keeps, std::min(other.held, own + bytes));
    least += other.keeps;
  }
  if (least > max_pending_bytes_) return false;
  while (pending_bytes_ + bytes > max_pending_bytes_) {
    Holder& most = *std::max_element(others.begin(), others.end(), [](const Holder& a, const Holder& b) {
      return a.excess() < b.excess();
    });
    const std::size_t lost = pending_bytes(*pending_.take_newest(most.first).result);
    most.held -= lost;
    pending_bytes_ -= lost;
    ++dropped_;
  }
  return true;
}

void ResultTiers::flush(std::chrono::steady_clock::time_point until) {
  const auto done = [this] { return pending_.empty() && !writes_for_; };
  std::unique_lock lock(mutex_);
  if (until == std::chrono::steady_clock::time_point::max())
    written_.wait(lock, done);  // time_point::max() overflows in some implementations of wait_until
  else
    written_.wait_until(lock, until, done);
}

bool ResultTiers::keep_on_disk(const std::shared_ptr<const FractureResult>& result) {
  if (!disk_) return false;
  if (on_disk(result->key)) return true;
  const std::string metadata = metadata_of(*result);
  return write_to_disk({result->key, metadata, result->file});
}

bool ResultTiers::write_to_disk(const CacheEntry& entry) {
  const std::string key(entry.key);
  {
    std::unique_lock lock(mutex_);
    written_.wait(lock, [&] { return !to_disk_.contains(key); });
    to_disk_.insert(key);
  }
  struct AtEnd {
    ~AtEnd() {
      {
        const std::lock_guard lock(tiers.mutex_);
        tiers.to_disk_.erase(key);
      }
      tiers.written_.notify_all();
    }
    ResultTiers& tiers;
    const std::string& key;
  } const at_end{*this, key};
  return on_disk(key) || (disk_->insert(entry) && on_disk(key));
}

void ResultTiers::write_pending() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stopping_ || !pending_.empty(); });
    if (stopping_) return;
    const Queue::Next next = pending_.candidates(kAny).front();
    Queue::Client& client = *next.client;
    Pending pending = pending_.take(next);
    pending_bytes_ -= pending_bytes(*pending.result);
    writes_for_ = pending.flow.name;
    lock.unlock();
    const auto begin = std::chrono::steady_clock::now();
    bool failed = false;
    try {
      write(pending);
    } catch (const std::exception&) {  // lack of memory
      failed = true;
    }
    pending.result.reset();  // without the lock
    const std::chrono::duration<double> used = std::chrono::steady_clock::now() - begin;
    lock.lock();
    dropped_ += failed;
    pending_.charge(kClass, pending.flow, used.count());
    pending_.advance(client.tag);
    pending_.end(client);
    writes_for_.reset();
    if (pending_.empty())
      pending_.idle();
    else if (pending_.flows() > kMostRemembered)
      pending_.sweep(kMostRemembered);
    written_.notify_all();
  }
}

void ResultTiers::write(const Pending& pending) {
  const std::string metadata = metadata_of(*pending.result);
  const CacheEntry entry{pending.result->key, metadata, pending.result->file};
  if (disk_) write_to_disk(entry);
  if (redis_ && pending.to_redis) redis_->insert(entry);
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
