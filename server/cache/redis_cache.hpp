// L2: entries in a Redis (or Valkey) that several servers share. Values are zstd frames of entries
// (entry.hpp), so that a value damaged or written by another program is a miss; with keys of the farm they
// are signed (farm_keys.hpp), and what is not is a miss before it is decompressed. Whatever the other side
// does (is down, is silent, trickles, talks nonsense), a call ends in time and is at worst a miss.
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
  std::string address;         ///< host:port, or the path of a socket (begins with '/'); empty: none
  std::string user, password;  ///< of AUTH, where there is a password; without a user: Redis' default one
  RedisTlsConfig tls;
  FarmKeys keys;                                   ///< empty: values are not signed, and Redis is trusted
  int algorithm = 0;                               ///< its version, part of what is signed
  std::chrono::milliseconds connect_timeout{100};  ///< of TCP, TLS and AUTH together; three times it with TLS
  std::chrono::milliseconds operation_timeout{50};  ///< of a whole operation, however it trickles
  std::size_t max_value_bytes = 4u << 20;           ///< of a value as it is sent, compressed
  std::uint64_t max_entry_bytes = 64ull << 20;      ///< of an entry after decompression
  std::chrono::seconds ttl{7 * 86'400};             ///< given to Redis with each value
};

struct RedisFigures {
  std::uint64_t hits = 0, misses = 0, writes = 0;
  std::uint64_t failures = 0;  ///< down, late, or not making sense
  std::uint64_t skipped = 0;   ///< not asked, because it had not answered before
  std::uint64_t damaged = 0;   ///< values that were no intact entry, or none that the farm has signed
  bool open = false;           ///< it is not being asked
};

/// Thread-safe; a call blocks for at most connect_timeout (see there) + twice the operation_timeout, and
/// never for a name server: until a name is resolved, and while it has no address, every call misses. The
/// process has to ignore SIGPIPE: OpenSSL writes to sockets that may have been closed.
class RedisCache {
 public:
  /// Without TLS where its files cannot be read, every call fails: see RedisTls::load().
  explicit RedisCache(RedisConfig config);
  ~RedisCache();
  RedisCache(const RedisCache&) = delete;
  RedisCache& operator=(const RedisCache&) = delete;

  std::optional<StoredEntry> find(const std::string& key, const Room& room = {});
  /// False when it was not stored.
  bool insert(const CacheEntry& entry);
  /// What find() found is intact and not what it should be: it counts as damaged. The next insert replaces it.
  void refuse();

  RedisFigures figures() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Connection = std::unique_ptr<RedisConnection>;

  /// One command; null when it failed. Counts and tells the breaker.
  RedisReply ask(const std::vector<std::string_view>& command);
  /// With its user and password said; null when that failed.
  Connection connect();
  Connection open(Clock::time_point deadline);
  SignedAs signed_as(std::string_view key) const { return {"redis", key, config_.algorithm}; }
  /// `no_room`: it was not looked at for want of that.
  std::optional<StoredEntry> decoded(std::span<const std::uint8_t> value, const std::string& key,
                                     const Room& room, bool& no_room) const;

  const RedisConfig config_;
  std::string host_;
  std::shared_ptr<const RedisTls> tls_;
  bool unusable_ = false;               ///< TLS is wanted and cannot be had
  std::unique_ptr<Resolver> resolver_;  ///< none for a socket by path
  CircuitBreaker breaker_;
  mutable std::mutex mutex_;
  std::vector<Connection> idle_;
  RedisFigures figures_;
};

}  // namespace fracture
