#include "server/cache/redis_cache.hpp"

#include <fcntl.h>
#include <hiredis/hiredis.h>
#include <poll.h>
#include <zstd.h>

#include <charconv>
#include <string_view>
#include <utility>

namespace fracture {
namespace {

constexpr std::size_t kMaxIdle = 8;
constexpr int kCompression = 1;  // 500 MB/s; GLB files shrink by half, and no more with higher levels

timeval to_timeval(std::chrono::milliseconds time) {
  return {static_cast<time_t>(time.count() / 1000), static_cast<suseconds_t>(time.count() % 1000 * 1000)};
}

/// Waits for the socket; false when the time is over.
bool wait_for(int fd, short events, std::chrono::steady_clock::time_point deadline) {
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
  if (left.count() <= 0) return false;
  pollfd p{fd, events, 0};
  return ::poll(&p, 1, static_cast<int>(left.count())) > 0;
}

}  // namespace

RedisCache::RedisCache(RedisConfig config) : config_(std::move(config)) {}
RedisCache::~RedisCache() = default;

RedisCache::Context RedisCache::connect() const {
  const timeval time = to_timeval(config_.connect_timeout);
  redisContext* context = nullptr;
  if (config_.address.front() == '/') {
    context = redisConnectUnixWithTimeout(config_.address.c_str(), time);
  } else {
    const std::size_t colon = config_.address.rfind(':');
    std::string host = config_.address.substr(0, colon);
    if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
    int port = 6379;
    if (colon != std::string::npos)
      std::from_chars(config_.address.data() + colon + 1, config_.address.data() + config_.address.size(),
                      port);
    context = redisConnectWithTimeout(host.c_str(), port, time);
  }
  Context owned(context, &redisFree);
  if (!owned || owned->err) return Context(nullptr, &redisFree);
  ::fcntl(owned->fd, F_SETFL, ::fcntl(owned->fd, F_GETFL) | O_NONBLOCK);  // exchange() waits by itself
  return owned;
}

/// hiredis' own timeout is one for each system call, which an answer of single bytes never reaches: the loop
/// is written out with one deadline for all of it.
RedisCache::Reply RedisCache::exchange(redisContext& context, const std::vector<std::string_view>& command,
                                       Clock::time_point deadline) {
  Reply none(nullptr, &freeReplyObject);
  std::vector<const char*> arguments;
  std::vector<std::size_t> sizes;
  for (const std::string_view part : command) {
    arguments.push_back(part.data());
    sizes.push_back(part.size());
  }
  if (redisAppendCommandArgv(&context, static_cast<int>(command.size()), arguments.data(), sizes.data()) !=
      REDIS_OK)
    return none;
  context.flags &= ~REDIS_BLOCK;  // EAGAIN is no error then
  for (int done = 0; !done;) {
    if (!wait_for(context.fd, POLLOUT, deadline) || redisBufferWrite(&context, &done) != REDIS_OK)
      return none;
  }
  for (void* reply = nullptr;;) {
    // Neither GET nor SET answers with an array; hiredis would allocate as many elements as one declares.
    const redisReader& reader = *context.reader;
    if (reader.len > reader.pos && reader.buf[reader.pos] == '*') return none;
    if (redisGetReplyFromReader(&context, &reply) != REDIS_OK) return none;
    if (reply) return Reply(static_cast<redisReply*>(reply), &freeReplyObject);
    if (!wait_for(context.fd, POLLIN, deadline) || redisBufferRead(&context) != REDIS_OK) return none;
  }
}

RedisCache::Reply RedisCache::ask(const std::vector<std::string_view>& command) {
  Reply none(nullptr, &freeReplyObject);
  if (!breaker_.allows()) {
    const std::lock_guard lock(mutex_);
    ++figures_.skipped;
    return none;
  }
  Context context(nullptr, &redisFree);
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      context = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  // A kept connection may have been closed meanwhile, which its first use finds out: then a new one.
  for (const bool kept : {true, false}) {
    if (kept && !context) continue;
    if (!kept) context = connect();
    if (!context) break;
    Reply reply = exchange(*context, command, Clock::now() + config_.operation_timeout);
    if (reply && reply->type != REDIS_REPLY_ERROR) {
      breaker_.success();
      const std::lock_guard lock(mutex_);
      if (idle_.size() < kMaxIdle) idle_.push_back(std::move(context));
      return reply;
    }
    const bool closed = context->err == REDIS_ERR_EOF || context->err == REDIS_ERR_IO;
    if (!kept || !closed) break;
  }
  breaker_.failure();
  const std::lock_guard lock(mutex_);
  ++figures_.failures;
  return none;
}

std::optional<StoredEntry> RedisCache::find(const std::string& key, const Room& room) {
  const std::string name = "fracture:" + key;
  const Reply reply = ask({"GET", name});
  if (!reply) return std::nullopt;
  std::optional<StoredEntry> stored;
  const bool there = reply->type == REDIS_REPLY_STRING;
  bool no_room = false;
  if (there && reply->len <= config_.max_value_bytes) {
    const unsigned long long size = ZSTD_getFrameContentSize(reply->str, reply->len);
    if (size != ZSTD_CONTENTSIZE_UNKNOWN && size != ZSTD_CONTENTSIZE_ERROR &&
        size <= config_.max_entry_bytes && !(no_room = room && !room(size))) {
      std::vector<std::uint8_t> bytes(size);
      if (ZSTD_decompress(bytes.data(), bytes.size(), reply->str, reply->len) == size)
        if (const auto entry = decode_entry(bytes, key)) stored = StoredEntry{std::move(bytes), *entry};
    }
  }
  const std::lock_guard lock(mutex_);
  ++(stored ? figures_.hits : figures_.misses);
  if (reply->type != REDIS_REPLY_NIL && !stored && !no_room) ++figures_.damaged;
  return stored;
}

bool RedisCache::insert(const CacheEntry& entry) {
  if (entry.payload.size() > config_.max_entry_bytes || breaker_.open()) {
    // Not worth compressing; reading tries again when it is time.
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
  const std::string name = "fracture:" + std::string(entry.key), ttl = std::to_string(config_.ttl.count());
  if (!ask({"SET", name, value, "EX", ttl})) return false;
  const std::lock_guard lock(mutex_);
  ++figures_.writes;
  return true;
}

RedisFigures RedisCache::figures() const {
  const std::lock_guard lock(mutex_);
  RedisFigures figures = figures_;
  figures.open = breaker_.open();
  return figures;
}

}  // namespace fracture
