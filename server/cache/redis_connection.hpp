// One connection to Redis: sockets and OpenSSL here, hiredis for the protocol alone (Debian's has no TLS, and
// its timeouts are for each system call, which an answer of single bytes never reaches). Every call has one
// deadline for all of it.
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
  std::string ca_file;              ///< who may have signed the server's certificate; empty: the system's
  std::string cert_file, key_file;  ///< our own, where the server asks for one (PEM); both or none
};

/// Certificates, read once; the server's is always checked, with its name. Immutable.
class RedisTls {
 public:
  /// kFileAccess says what cannot be read.
  static Expected<std::shared_ptr<const RedisTls>> load(const RedisTlsConfig& config);
  ssl_ctx_st* context() const { return context_.get(); }

 private:
  std::unique_ptr<ssl_ctx_st, void (*)(ssl_ctx_st*)> context_{nullptr, nullptr};
};

using RedisReply = std::unique_ptr<redisReply, void (*)(void*)>;

class RedisConnection {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// Null when the deadline passes, nobody answers, or the certificate is not that of `host`. `tls` may be
  /// null. `max_reply`: bytes of an answer; a longer one is a failure.
  static std::unique_ptr<RedisConnection> open(const NetworkAddress& address, const std::string& host,
                                               const RedisTls* tls, std::size_t max_reply, Deadline deadline);
  ~RedisConnection();
  RedisConnection(const RedisConnection&) = delete;
  RedisConnection& operator=(const RedisConnection&) = delete;

  /// The answer, an error of Redis too; null when it failed: then the connection is of no more use.
  RedisReply ask(const std::vector<std::string_view>& command, Deadline deadline);
  /// Why it failed: the other side had closed it, perhaps long ago.
  bool was_closed() const { return closed_; }

 private:
  RedisConnection(int fd, std::size_t max_reply);
  bool connect(const NetworkAddress& address, Deadline deadline);
  bool shake_hands(const RedisTls& tls, const std::string& host, Deadline deadline);
  bool write(std::string_view bytes, Deadline deadline);
  /// 0: it failed.
  std::size_t read_some(char* to, std::size_t size, Deadline deadline);
  /// What a call of OpenSSL that did not get on waits for.
  bool wait_as_told(int result, Deadline deadline);

  const int fd_;
  const std::size_t max_reply_;
  std::unique_ptr<ssl_st, void (*)(ssl_st*)> ssl_;
  std::unique_ptr<redisReader, void (*)(redisReader*)> reader_;
  bool closed_ = false;
};

}  // namespace fracture
