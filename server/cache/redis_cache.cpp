#include "server/cache/redis_cache.hpp"

#include <hiredis/hiredis.h>
#include <sys/un.h>
#include <zstd.h>

#include <cstddef>
#include <string_view>
#include <utility>

namespace fracture {
namespace {

constexpr std::size_t kMaxIdle = 8;
constexpr int kCompression = 1;  // 500 MB/s; halves GLB files, and higher levels do not shrink them further
/// Factor on the connect timeout with TLS, because a handshake takes two round trips and a signature.
constexpr int kTlsPatience = 3;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

RedisCache::RedisCache(RedisConfig config) : config_(std::move(config)) {
  if (config_.tls.on) {
    if (auto tls = RedisTls::load(config_.tls))
      tls_ = std::move(*tls);
    else
      unusable_ = true;
  }
  if (config_.address.front() == '/') return;
  const std::size_t colon = config_.address.rfind(':');
  host_ = config_.address.substr(0, colon);
  if (host_.size() > 2 && host_.front() == '[') host_ = host_.substr(1, host_.size() - 2);
  resolver_ = std::make_unique<Resolver>(
      host_, colon == std::string::npos ? "6379" : config_.address.substr(colon + 1));
}

RedisCache::~RedisCache() = default;

RedisCache::Connection RedisCache::open(Clock::time_point deadline) {
  const std::size_t most = config_.max_value_bytes + FarmKeys::kHead;
  if (!resolver_) {
    NetworkAddress socket;
    auto& path = reinterpret_cast<sockaddr_un&>(socket.storage);
    path.sun_family = AF_UNIX;
    socket.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + config_.address.size() + 1);
    if (config_.address.size() >= sizeof path.sun_path) return nullptr;
    config_.address.copy(path.sun_path, sizeof path.sun_path - 1);
    return RedisConnection::open(socket, host_, tls_.get(), most, deadline);
  }
  for (const NetworkAddress& address : resolver_->known().addresses)
    if (auto connection = RedisConnection::open(address, host_, tls_.get(), most, deadline))
      return connection;
  return nullptr;
}

RedisCache::Connection RedisCache::connect() {
  if (unusable_) return nullptr;
  const auto deadline = Clock::now() + config_.connect_timeout * (tls_ ? kTlsPatience : 1);
  Connection connection = open(deadline);
  if (!connection || config_.password.empty()) return connection;
  std::vector<std::string_view> command = {"AUTH"};
  if (!config_.user.empty()) command.push_back(config_.user);
  command.push_back(config_.password);
  const RedisReply reply = connection->ask(command, deadline);
  return reply && reply->type == REDIS_REPLY_STATUS ? std::move(connection) : nullptr;
}

RedisReply RedisCache::ask(const std::vector<std::string_view>& command) {
  RedisReply none(nullptr, &freeReplyObject);
  if ((resolver_ && !resolver_->known().asked) || !breaker_.allows()) {
    const std::lock_guard lock(mutex_);
    ++figures_.skipped;
    return none;
  }
  Connection connection;
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      connection = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  // An idle connection may have been closed in the meantime, which only its next use shows. Then a new one is opened.
  for (const bool kept : {true, false}) {
    if (kept && !connection) continue;
    if (!kept) connection = connect();
    if (!connection) break;
    RedisReply reply = connection->ask(command, Clock::now() + config_.operation_timeout);
    if (reply && reply->type != REDIS_REPLY_ERROR) {
      breaker_.success();
      const std::lock_guard lock(mutex_);
      if (idle_.size() < kMaxIdle) idle_.push_back(std::move(connection));
      return reply;
    }
    if (!kept || !connection->was_closed()) break;
  }
  breaker_.failure();
  const std::lock_guard lock(mutex_);
  ++figures_.failures;
  return none;
}

std::optional<StoredEntry> RedisCache::decoded(std::span<const std::uint8_t> value, const std::string& key,
                                               const Room& room, bool& no_room,
                                               const Execution& execution) const {
  if (!config_.keys.empty()) {
    const auto opened = config_.keys.open(signed_as(key), value, execution);
    if (!opened) return std::nullopt;
    value = *opened;
  }
  if (value.size() > config_.max_value_bytes) return std::nullopt;
  const unsigned long long size = ZSTD_getFrameContentSize(value.data(), value.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > config_.max_entry_bytes)
    return std::nullopt;
  no_room = room && !room(size);
  if (no_room) return std::nullopt;
  std::vector<std::uint8_t> bytes(size);
  if (ZSTD_decompress(bytes.data(), bytes.size(), value.data(), value.size()) != size) return std::nullopt;
  const auto entry = decode_entry(bytes, key, execution);
  return entry ? std::optional(StoredEntry{std::move(bytes), *entry}) : std::nullopt;
}

std::optional<StoredEntry> RedisCache::find(const std::string& key, const Room& room,
                                            const Execution& execution) {
  const std::string name = "fracture:" + key;
  const RedisReply reply = ask({"GET", name});
  if (!reply) return std::nullopt;
  std::optional<StoredEntry> stored;
  bool no_room = false;
  if (reply->type == REDIS_REPLY_STRING)
    stored = decoded(bytes_of({reply->str, reply->len}), key, room, no_room, execution);
  const std::lock_guard lock(mutex_);
  ++(stored ? figures_.hits : figures_.misses);
  if (reply->type != REDIS_REPLY_NIL && !stored && !no_room) ++figures_.damaged;
  return stored;
}

bool RedisCache::insert(const CacheEntry& entry) {
  if (entry.payload.size() > config_.max_entry_bytes || breaker_.open()) {
    // Compressing the entry is not worth it. Only reads check whether Redis answers again.
    const std::lock_guard lock(mutex_);
    ++figures_.skipped;
    return false;
  }
  std::string whole = encode_entry_head(entry);
  whole.append(reinterpret_cast<const char*>(entry.payload.data()), entry.payload.size());
  std::string value(ZSTD_compressBound(whole.size()), '\0');
  const std::size_t size =
      ZSTD_compress(value.data(), value.size(), whole.data(), whole.size(), kCompression);
  if (ZSTD_isError(size) || size > config_.max_value_bytes) return false;
  value.resize(size);
  if (!config_.keys.empty()) value.insert(0, config_.keys.head(signed_as(entry.key), {bytes_of(value)}));
  const std::string name = "fracture:" + std::string(entry.key), ttl = std::to_string(config_.ttl.count());
  if (!ask({"SET", name, value, "EX", ttl})) return false;
  const std::lock_guard lock(mutex_);
  ++figures_.writes;
  return true;
}

void RedisCache::refuse() {
  const std::lock_guard lock(mutex_);
  ++figures_.damaged;
}

RedisFigures RedisCache::figures() const {
  const std::lock_guard lock(mutex_);
  RedisFigures figures = figures_;
  figures.open = breaker_.open();
  return figures;
}

}  // namespace fracture
