#include "server/service/result_tiers.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "common/pipeline/fracture.hpp"

namespace fracture {
namespace {

/// An entry as it was read, and the result that is made of it.
constexpr std::uint64_t kCopies = 2;

constexpr std::size_t kDigest = sizeof(Digest::bytes);

std::string_view text_of(const Digest& digest) {
  return {reinterpret_cast<const char*>(digest.bytes.data()), digest.bytes.size()};
}

/// The metadata of an entry: format, mesh digest, and where figures and parameters stand in the file (begin
/// and size of each) as lines, then the digests of file and figures.
std::string metadata_of(const FractureResult& result) {
  std::string text = result.format == OutputFormat::kGltf ? "gltf" : "glb";
  text += "\n" + result.mesh_digest + "\n";
  for (const TextRange& range : {result.figures, result.parameters})
    text += std::to_string(range.at) + " " + std::to_string(range.size) + " ";
  text.back() = '\n';
  return text.append(text_of(result.file_digest)).append(text_of(result.figures_digest));
}

/// The two ranges of a line; false for anything else, and where they are no objects of the file.
bool read_ranges(std::string_view line, FractureResult& result) {
  std::uint64_t numbers[4];
  for (std::uint64_t& number : numbers) {
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
    if (error != std::errc{}) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  }
  result.figures = {numbers[0], numbers[1]};
  result.parameters = {numbers[2], numbers[3]};
  const auto is_object = [&](TextRange range) {
    if (range.size == 0) return range.at <= result.file.size();
    return range.at <= result.file.size() && range.size <= result.file.size() - range.at &&
           result.file[range.at] == '{' && result.file[range.at + range.size - 1] == '}';
  };
  return line.empty() && is_object(result.figures) && is_object(result.parameters);
}

std::shared_ptr<const FractureResult> to_result(const StoredEntry& stored) {
  const std::string_view metadata = stored.entry.metadata;
  const std::size_t first = metadata.find('\n'), second = metadata.find('\n', first + 1);
  auto result = std::make_shared<FractureResult>();
  if (first == std::string_view::npos || second == std::string_view::npos) return nullptr;
  result->key = stored.entry.key;
  result->format = metadata.substr(0, first) == "gltf" ? OutputFormat::kGltf : OutputFormat::kGlb;
  result->mesh_digest = metadata.substr(first + 1, second - first - 1);
  // Result keys begin with the digest of their mesh.
  constexpr std::string_view kScheme = "sha256:";
  if (!std::string_view(result->mesh_digest).starts_with(kScheme) ||
      result->mesh_digest.compare(kScheme.size(), 16, result->key, 0, 16) != 0)
    return nullptr;
  result->file.assign(stored.entry.payload.begin(), stored.entry.payload.end());
  // Digests are not taken on trust: clients are told them (Repr-Digest), and believe the file for them.
  result->file_digest = sha256(std::as_bytes(std::span(result->file)));
  const std::string_view rest = metadata.substr(second + 1);
  if (rest == text_of(result->file_digest)) {  // as earlier versions wrote it: without places
    locate_figures(*result);
    return result;
  }
  const std::size_t third = rest.find('\n');
  if (third == std::string_view::npos || rest.size() - third - 1 != 2 * kDigest ||
      rest.substr(third + 1, kDigest) != text_of(result->file_digest) ||
      !read_ranges(rest.substr(0, third), *result))
    return nullptr;
  result->figures_digest =
      sha256(std::as_bytes(std::span(result->file).subspan(result->figures.at, result->figures.size)));
  return rest.substr(third + 1 + kDigest) == text_of(result->figures_digest) ? result : nullptr;
}

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

void ResultTiers::flush(std::chrono::steady_clock::time_point until) {
  const auto done = [this] { return pending_.empty() && writing_.empty(); };
  std::unique_lock lock(mutex_);
  if (until == std::chrono::steady_clock::time_point::max())
    written_.wait(lock, done);  // the clock's last moment overflows in some implementations of wait_until
  else
    written_.wait_until(lock, until, done);
}

bool ResultTiers::keep_on_disk(const std::shared_ptr<const FractureResult>& result) {
  if (!disk_) return false;
  {
    // The thread that writes behind answers may be about to.
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
