#include "server/cache/redis_connection.hpp"

#include <arpa/inet.h>
#include <hiredis/hiredis.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "common/base/wait_for.hpp"

namespace fracture {
namespace {

/// Bytes allowed in a reply in addition to the value.
constexpr std::size_t kSlack = 64u << 10;

bool is_numeric(const std::string& host) {
  in6_addr address{};
  return ::inet_pton(AF_INET, host.c_str(), &address) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

}  // namespace

Expected<std::shared_ptr<const RedisTls>> RedisTls::load(const RedisTlsConfig& config) {
  auto tls = std::make_shared<RedisTls>();
  tls->context_ = {SSL_CTX_new(TLS_client_method()), &SSL_CTX_free};
  SSL_CTX* const context = tls->context();
  if (!context) return fail(ErrorCode::kInternal, "TLS cannot be set up");
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  const bool trusts = config.ca_file.empty()
                          ? SSL_CTX_set_default_verify_paths(context) == 1
                          : SSL_CTX_load_verify_locations(context, config.ca_file.c_str(), nullptr) == 1;
  const bool shows = config.cert_file.empty() ||
                     (SSL_CTX_use_certificate_chain_file(context, config.cert_file.c_str()) == 1 &&
                      SSL_CTX_use_PrivateKey_file(context, config.key_file.c_str(), SSL_FILETYPE_PEM) == 1 &&
                      SSL_CTX_check_private_key(context) == 1);
  ERR_clear_error();
  if (!trusts) return fail(ErrorCode::kFileAccess, config.ca_file + " contains no readable certificate");
  if (!shows)
    return fail(ErrorCode::kFileAccess,
                config.cert_file + " and " + config.key_file + " are not a matching certificate and key");
  return tls;
}

RedisConnection::RedisConnection(int fd, std::size_t max_reply)
    : fd_(fd),
      max_reply_(max_reply + kSlack),
      ssl_(nullptr, &SSL_free),
      reader_(redisReaderCreate(), &redisReaderFree) {}

RedisConnection::~RedisConnection() {
  ssl_.reset();  // without a TLS close message, because nobody waits for it
  ::close(fd_);
}

std::unique_ptr<RedisConnection> RedisConnection::open(const NetworkAddress& address, const std::string& host,
                                                       const RedisTls* tls, std::size_t max_reply,
                                                       Deadline deadline) {
  const int fd = ::socket(address.get()->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return nullptr;
  std::unique_ptr<RedisConnection> made(new RedisConnection(fd, max_reply));
  if (!made->reader_ || !made->connect(address, deadline)) return nullptr;
  if (tls && !made->shake_hands(*tls, host, deadline)) return nullptr;
  return made;
}

bool RedisConnection::connect(const NetworkAddress& address, Deadline deadline) {
  const int one = 1;
  if (address.get()->sa_family != AF_UNIX) ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  if (::connect(fd_, address.get(), address.size) == 0) return true;
  if (errno != EINPROGRESS || wait_for(fd_, POLLOUT, deadline) == 0) return false;
  int error = 0;
  socklen_t size = sizeof error;
  return ::getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0;
}

bool RedisConnection::shake_hands(const RedisTls& tls, const std::string& host, Deadline deadline) {
  ssl_.reset(SSL_new(tls.context()));
  if (!ssl_ || SSL_set_fd(ssl_.get(), fd_) != 1) return false;
  if (is_numeric(host)) {
    if (X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(ssl_.get()), host.c_str()) != 1) return false;
  } else if (SSL_set1_host(ssl_.get(), host.c_str()) != 1 ||
             SSL_set_tlsext_host_name(ssl_.get(), host.c_str()) != 1) {
    return false;
  }
  for (;;) {
    ERR_clear_error();
    const int result = SSL_connect(ssl_.get());
    if (result == 1) return true;
    if (!wait_as_told(result, deadline)) return false;
  }
}

bool RedisConnection::wait_as_told(int result, Deadline deadline) {
  switch (SSL_get_error(ssl_.get(), result)) {
    case SSL_ERROR_WANT_READ:
      return wait_for(fd_, POLLIN, deadline) != 0;
    case SSL_ERROR_WANT_WRITE:
      return wait_for(fd_, POLLOUT, deadline) != 0;
    default:
      closed_ = true;
      return false;
  }
}

bool RedisConnection::write(std::string_view bytes, Deadline deadline) {
  while (!bytes.empty()) {
    if (ssl_) {
      std::size_t written = 0;
      ERR_clear_error();
      const int result = SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &written);
      bytes.remove_prefix(written);
      if (result != 1 && !wait_as_told(result, deadline)) return false;
      continue;
    }
    const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno == EAGAIN) {
      if (wait_for(fd_, POLLOUT, deadline) == 0) return false;
    } else if (errno != EINTR) {
      closed_ = true;
      return false;
    }
  }
  return true;
}

std::size_t RedisConnection::read_some(char* to, std::size_t size, Deadline deadline) {
  for (;;) {
    if (ssl_) {
      std::size_t got = 0;
      ERR_clear_error();
      const int result = SSL_read_ex(ssl_.get(), to, size, &got);
      if (result == 1) return std::chrono::steady_clock::now() < deadline ? got : 0;
      if (!wait_as_told(result, deadline)) return 0;
      continue;
    }
    const ssize_t got = ::recv(fd_, to, size, 0);
    // The deadline is checked even if bytes are always available, because the other side may send without end.
    if (got > 0) return std::chrono::steady_clock::now() < deadline ? static_cast<std::size_t>(got) : 0;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) {
      if (wait_for(fd_, POLLIN, deadline) == 0) return 0;
      continue;
    }
    closed_ = true;
    return 0;
  }
}

RedisReply RedisConnection::ask(const std::vector<std::string_view>& command, Deadline deadline) {
  RedisReply none(nullptr, &freeReplyObject);
  std::vector<const char*> arguments;
  std::vector<std::size_t> sizes;
  for (const std::string_view part : command) {
    arguments.push_back(part.data());
    sizes.push_back(part.size());
  }
  char* formatted = nullptr;
  const int length =
      redisFormatCommandArgv(&formatted, static_cast<int>(command.size()), arguments.data(), sizes.data());
  if (length < 0) return none;
  const std::unique_ptr<char, void (*)(char*)> owned(formatted, &redisFreeCommand);
  if (!write({formatted, static_cast<std::size_t>(length)}, deadline)) return none;
  char block[16u << 10];
  for (std::size_t received = 0;;) {
    const std::size_t got = read_some(block, sizeof block, deadline);
    received += got;
    if (got == 0 || received > max_reply_ || redisReaderFeed(reader_.get(), block, got) != REDIS_OK)
      return none;
    // None of our commands returns an array. An array is rejected because hiredis would allocate as many elements as it
    // declares.
    if (reader_->len > reader_->pos && reader_->buf[reader_->pos] == '*') return none;
    void* reply = nullptr;
    if (redisReaderGetReply(reader_.get(), &reply) != REDIS_OK) return none;
    if (reply) return RedisReply(static_cast<redisReply*>(reply), &freeReplyObject);
  }
}

}  // namespace fracture
