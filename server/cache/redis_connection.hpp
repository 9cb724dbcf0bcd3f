// A connection to Redis. Sockets and TLS (OpenSSL) are handled here, and hiredis only parses the protocol. Debian's hiredis
// has no TLS, and its timeouts apply to each system call, so a reply that arrives byte by byte would never time out. Here,
// every call has one deadline for the whole call.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "server/cache/resolver.hpp"

struct redisReader;
struct redisReply;
struct ssl_ctx_st;
struct ssl_st;

namespace fracture {

struct RedisTlsConfig {
  bool on = false;
  std::string ca_file;              ///< trusted certificate authorities; empty: those of the system
  std::string cert_file, key_file;  ///< our certificate and key (PEM), if the server asks; both or neither
};

/// Certificates, read once. The server's certificate and its name are always checked. Immutable.
class RedisTls {
 public:
  /// Reads the files. Errors: kFileAccess, which names the unreadable file.
  static Expected<std::shared_ptr<const RedisTls>> load(const RedisTlsConfig& config);
  ssl_ctx_st* context() const { return context_.get(); }

 private:
  std::unique_ptr<ssl_ctx_st, void (*)(ssl_ctx_st*)> context_{nullptr, nullptr};
};

using RedisReply = std::unique_ptr<redisReply, void (*)(void*)>;

class RedisConnection {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// Opens a connection. Returns null if the deadline passes, nobody answers, or the certificate does not match `host`.
  /// `tls` may be null. `max_reply`: maximum size of a reply in bytes; a longer one is a failure.
  static std::unique_ptr<RedisConnection> open(const NetworkAddress& address, const std::string& host,
                                               const RedisTls* tls, std::size_t max_reply, Deadline deadline);
  ~RedisConnection();
  RedisConnection(const RedisConnection&) = delete;
  RedisConnection& operator=(const RedisConnection&) = delete;

  /// Sends a command and returns the reply, which may be an error from Redis. Returns null if it failed; the connection must
  /// not be used after that.
  RedisReply ask(const std::vector<std::string_view>& command, Deadline deadline);
  /// Returns whether ask() failed because the other side had closed the connection, perhaps long ago.
  bool was_closed() const { return closed_; }

 private:
  RedisConnection(int fd, std::size_t max_reply);
  bool connect(const NetworkAddress& address, Deadline deadline);
  bool shake_hands(const RedisTls& tls, const std::string& host, Deadline deadline);
  bool write(std::string_view bytes, Deadline deadline);
  /// Returns the number of bytes read; 0 if it failed.
  std::size_t read_some(char* to, std::size_t size, Deadline deadline);
  /// Waits until an incomplete OpenSSL call can continue. Returns false if it failed.
  bool wait_as_told(int result, Deadline deadline);

  const int fd_;
  const std::size_t max_reply_;
  std::unique_ptr<ssl_st, void (*)(ssl_st*)> ssl_;
  std::unique_ptr<redisReader, void (*)(redisReader*)> reader_;
  bool closed_ = false;
};

}  // namespace fracture
