#include "server/service/result_tiers.hpp"

#include <cstring>
#include <utility>

namespace fracture {
namespace {

/// An entry as it was read, and the result that is made of it.
constexpr std::uint64_t kCopies = 2;

/// The metadata of an entry: format, mesh digest, file digest as lines.
std::string metadata_of(const FractureResult& result) {
  return std::string(result.format == OutputFormat::kGltf ? "gltf" : "glb") + "\n" + result.mesh_digest +
         "\n" +
         std::string(reinterpret_cast<const char*>(result.file_digest.bytes.data()),
                     result.file_digest.bytes.size());
}

std::shared_ptr<const FractureResult> to_result(const StoredEntry& stored) {
  const std::string_view metadata = stored.entry.metadata;
  const std::size_t first = metadata.find('\n'), second = metadata.find('\n', first + 1);
  auto result = std::make_shared<FractureResult>();
  if (first == std::string_view::npos || second == std::string_view::npos ||
      metadata.size() - second - 1 != result->file_digest.bytes.size())
    return nullptr;
  result->key = stored.entry.key;
  result->format = metadata.substr(0, first) == "gltf" ? OutputFormat::kGltf : OutputFormat::kGlb;
  result->mesh_digest = metadata.substr(first + 1, second - first - 1);
  std::memcpy(result->file_digest.bytes.data(), metadata.data() + second + 1,
              result->file_digest.bytes.size());
  result->file.assign(stored.entry.payload.begin(), stored.entry.payload.end());
  return result;
}

}  // namespace

ResultTiers::ResultTiers(const TiersConfig& config) : max_pending_bytes_(config.max_pending_bytes) {
  if (!config.folder.empty()) {
    disk_ = std::make_unique<DiskCache>(config.folder, config.disk_bytes);
    disk_problem_ = disk_->unusable();
    if (!disk_problem_.empty()) disk_.reset();
  }
  if (!config.redis.address.empty()) redis_ = std::make_unique<RedisCache>(config.redis);
  if (any()) writer_ = std::thread([this] { write_pending(); });
}

ResultTiers::~ResultTiers() {
  if (!writer_.joinable()) return;
  {
    std::unique_lock lock(mutex_);
    written_.wait_for(lock, std::chrono::seconds(1), [this] { return pending_.empty() && !writing_; });
    pending_.clear();
    stopping_ = true;
  }
  wake_.notify_one();
  writer_.join();
}

std::optional<std::uint64_t> ResultTiers::expected_bytes(const std::string& key) const {
  constexpr std::uint64_t kUsual = 1u
                                   << 20;  // a game's answer; Redis says how large an entry is with the entry
  if (const auto size = disk_ ? disk_->size_of(key) : std::nullopt) return size;
  return redis_ ? std::optional(kUsual) : std::nullopt;
}

ResultTiers::Found ResultTiers::find(const std::string& key, const Room& room) {
  Found found;
  if (disk_) {
    const std::optional<std::uint64_t> size = disk_->size_of(key);
    found.no_room = size && room && !room(kCopies * *size);
    if (found.no_room) return found;
    found.disk = CacheOutcome::kMissNotStored;
    if (const auto stored = disk_->find(key)) found.result = to_result(*stored);
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
    if (const auto stored = redis_->find(key, room_for_it)) found.result = to_result(*stored);
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

void ResultTiers::flush() {
  std::unique_lock lock(mutex_);
  written_.wait(lock, [this] { return pending_.empty() && !writing_; });
}

void ResultTiers::write_pending() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stopping_ || !pending_.empty(); });
    if (stopping_) return;
    const Pending pending = std::move(pending_.front());
    pending_.pop_front();
    writing_ = true;
    lock.unlock();
    const std::string metadata = metadata_of(*pending.result);
    const CacheEntry entry{pending.result->key, metadata, pending.result->file};
    if (disk_) disk_->insert(entry);
    if (redis_ && pending.to_redis) redis_->insert(entry);
    lock.lock();
    writing_ = false;
    pending_bytes_ -= pending.result->file.size();
    if (pending_.empty()) written_.notify_all();
  }
}

TiersFigures ResultTiers::figures() const {
  TiersFigures figures;
  if (disk_) figures.disk = disk_->figures();
  if (redis_) figures.redis = redis_->figures();
  const std::lock_guard lock(mutex_);
  figures.dropped = dropped_;
  return figures;
}

}  // namespace fracture
