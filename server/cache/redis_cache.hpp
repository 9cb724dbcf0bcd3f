// L2: entries in a Redis (or Valkey) that several servers share. Values are zstd frames of entries
// (entry.hpp), so that a value damaged or written by another program is a miss. Whatever the other side does
// (is down, is silent, trickles, talks nonsense), a call ends in time and is at worst a miss.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/cache/circuit_breaker.hpp"
#include "server/cache/disk_cache.hpp"

struct redisContext;
struct redisReply;

namespace fracture {

struct RedisConfig {
  std::string address;  ///< host:port, or the path of a socket (begins with '/'); empty: none
  std::chrono::milliseconds connect_timeout{100};
  std::chrono::milliseconds operation_timeout{50};  ///< of a whole operation, however it trickles
  std::size_t max_value_bytes = 4u << 20;           ///< of a value as it is sent, compressed
  std::uint64_t max_entry_bytes = 64ull << 20;      ///< of an entry after decompression
  std::chrono::seconds ttl{7 * 86'400};             ///< given to Redis with each value
};

struct RedisFigures {
  std::uint64_t hits = 0, misses = 0, writes = 0;
  std::uint64_t failures = 0;  ///< down, late, or not making sense
  std::uint64_t skipped = 0;   ///< not asked, because it had not answered before
  std::uint64_t damaged = 0;   ///< values that were no intact entry
  bool open = false;           ///< it is not being asked
};

/// Thread-safe; a call blocks for at most connect_timeout + operation_timeout. The process has to ignore
/// SIGPIPE: hiredis writes to sockets that may have been closed.
class RedisCache {
 public:
  explicit RedisCache(RedisConfig config);
  ~RedisCache();
  RedisCache(const RedisCache&) = delete;
  RedisCache& operator=(const RedisCache&) = delete;

  std::optional<StoredEntry> find(const std::string& key, const Room& room = {});
  /// False when it was not stored.
  bool insert(const CacheEntry& entry);

  RedisFigures figures() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Context = std::unique_ptr<redisContext, void (*)(redisContext*)>;
  using Reply = std::unique_ptr<redisReply, void (*)(void*)>;

  /// One command; null when it failed. Counts and tells the breaker.
  Reply ask(const std::vector<std::string_view>& command);
  Context connect() const;
  static Reply exchange(redisContext& context, const std::vector<std::string_view>& command,
                        Clock::time_point deadline);

  const RedisConfig config_;
  CircuitBreaker breaker_;
  mutable std::mutex mutex_;
  std::vector<Context> idle_;
  RedisFigures figures_;
};

}  // namespace fracture
