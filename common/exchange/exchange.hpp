// HTTP requests and their outcomes as plain data, without network access. This is the only module of common/
// that uses the network. The client of a game and `bake --server` are built on it; the pipeline does not use
// it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace fracture::protocol {

using Milliseconds = std::chrono::milliseconds;

struct TlsTrust;

/// Host and port as in a URL and in the Host field: an IPv6 address is in brackets (RFC 3986, 3.2.2).
inline std::string authority_of(const std::string& host, const std::string& port) {
  const bool brackets = host.find(':') != std::string::npos;
  return (brackets ? "[" + host + "]" : host) + ":" + port;
}

/// The server's address, and how long to wait for it.
struct ConnectionSettings {
  std::string host = "127.0.0.1";  ///< name or address; an IPv6 address without brackets
  std::uint16_t port = 8080;
  std::shared_ptr<TlsTrust> tls;  ///< HTTPS (tls.hpp); null: HTTP
  std::string token;              ///< sent as `Authorization: Bearer …` unless empty
  std::size_t connections = 4;    ///< maximum number kept alive; further requests wait for one of them
  Milliseconds connect_timeout{1000};
  Milliseconds answer_timeout{10'000};  ///< from the first byte sent to the last byte received
  Milliseconds idle{10'000};  ///< a connection unused for longer is replaced (the server's limit is 15 s)
  std::size_t max_answer_bytes = std::size_t{256} << 20;

  std::string authority() const { return authority_of(host, std::to_string(port)); }
  /// "https://[::1]:8443"
  std::string url() const { return (tls ? "https://" : "http://") + authority(); }
};

struct HttpRequest {
  const char* method = "GET";
  std::string target;
  std::string content_type{};
  std::shared_ptr<const std::string> body{};  ///< may be null
  std::vector<std::pair<std::string, std::string>> fields{};
  Milliseconds answer_timeout{0};  ///< 0: the timeout of the settings
};

/// How an exchange ended.
struct Exchange {
  enum class Outcome {
    kAnswered,     ///< with any status
    kNoServer,     ///< no server listens, or the name is unknown
    kBroken,       ///< closed or reset before the answer was complete, or the answer is not HTTP
    kTimedOut,     ///< while connecting, or after answer_timeout
    kTooLarge,     ///< larger than max_answer_bytes
    kInterrupted,  ///< stopped by interrupt()
  };
  Outcome outcome = Outcome::kInterrupted;
  std::string detail;
  bool began = false;  ///< part of the answer arrived
  int status = 0;
  std::string body, repr_digest, server_timing, retry_after, content_type, content_location;
};

/// Lets another function interrupt the current wait of a request.
struct Interruption {
  bool requested = false;
  std::function<void()> wake;  ///< ends the wait; empty if there is none
  void request() {
    requested = true;
    if (wake) wake();
  }
};

}  // namespace fracture::protocol
