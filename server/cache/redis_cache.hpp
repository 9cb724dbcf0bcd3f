// L2: entries in a Redis (or Valkey) that several servers share. Values are zstd frames of entries (entry.hpp), so a value
// that is damaged or was written by another program is a miss. With farm keys, values are signed (farm_keys.hpp); an unsigned
// value is a miss and is never decompressed. A call always ends in time and is at worst a miss, even if the other side is
// down, is silent, sends single bytes, or sends nonsense.
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
#include "server/cache/farm_keys.hpp"
#include "server/cache/redis_connection.hpp"
#include "server/cache/resolver.hpp"

namespace fracture {

struct RedisConfig {
  std::string address;         ///< host:port, or the path of a socket (begins with '/'); empty: no Redis
  std::string user, password;  ///< for AUTH, if there is a password; without a user: Redis' default user
  RedisTlsConfig tls;
  FarmKeys keys;                                    ///< empty: values are not signed, and Redis is trusted
  int algorithm = 0;                                ///< algorithm version, which is signed with each value
  std::chrono::milliseconds connect_timeout{100};   ///< for TCP, TLS and AUTH together; tripled with TLS
  std::chrono::milliseconds operation_timeout{50};  ///< for a whole operation, even if bytes keep arriving
  std::size_t max_value_bytes = 4u << 20;           ///< limit on a compressed value
  std::uint64_t max_entry_bytes = 64ull << 20;      ///< limit on an entry after decompression
  std::chrono::seconds ttl{7 * 86'400};             ///< expiry that Redis gets with each value
};

struct RedisFigures {
  std::uint64_t hits = 0, misses = 0, writes = 0;
  std::uint64_t failures = 0;  ///< operations without a valid answer in time
  std::uint64_t skipped = 0;   ///< operations not tried, because Redis had not answered before
  std::uint64_t damaged = 0;   ///< values that are not intact entries, or not signed by the farm
  bool open = false;           ///< the circuit breaker is open: Redis is not asked
};

/// Thread-safe. A call blocks for at most connect_timeout (tripled with TLS) plus twice the operation_timeout. It never waits
/// for a name server: until a name is resolved, and while it has no address, every call misses. The process must ignore
/// SIGPIPE, because OpenSSL writes to sockets that may have been closed.
class RedisCache {
 public:
  /// If the TLS files cannot be read, every call fails: call RedisTls::load() first to get the error.
  explicit RedisCache(RedisConfig config);
  ~RedisCache();
  RedisCache(const RedisCache&) = delete;
  RedisCache& operator=(const RedisCache&) = delete;

  /// Throws Interrupted.
  std::optional<StoredEntry> find(const std::string& key, const Room& room = {},
                                  const Execution& execution = kUninterrupted);
  /// Returns false if the entry was not stored.
  bool insert(const CacheEntry& entry);
  /// Counts an entry as damaged. For entries from find() that are intact but have wrong content. The next insert() replaces
  /// the entry.
  void refuse();
  /// Decodes a value; nothing if it is not an intact entry. Sets `no_room` if it was not decoded because `room` refused.
  /// Public for the fuzz target.
  std::optional<StoredEntry> decoded(std::span<const std::uint8_t> value, const std::string& key,
                                     const Room& room, bool& no_room,
                                     const Execution& execution = kUninterrupted) const;

  RedisFigures figures() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Connection = std::unique_ptr<RedisConnection>;

  /// Sends one command and returns its reply; null if it failed. Updates the statistics and the breaker.
  RedisReply ask(const std::vector<std::string_view>& command);
  /// Opens a connection and authenticates; null if that failed.
  Connection connect();
  Connection open(Clock::time_point deadline);
  SignedAs signed_as(std::string_view key) const { return {"redis", key, config_.algorithm}; }

  const RedisConfig config_;
  std::string host_;
  std::shared_ptr<const RedisTls> tls_;
  bool unusable_ = false;               ///< TLS is configured but its files cannot be read
  std::unique_ptr<Resolver> resolver_;  ///< null for a socket path
  CircuitBreaker breaker_;
  mutable std::mutex mutex_;
  std::vector<Connection> idle_;
  RedisFigures figures_;
};

}  // namespace fracture
