// A client of plain sockets: sends exactly the bytes it is given, so that a test can be as rude as it likes.
#pragma once

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tests/server/record.hpp"

namespace fracture::test {

struct Reply {
  int status = 0;
  std::map<std::string, std::string> headers;  ///< names in lower case
  std::string body;

  const std::string& header(const std::string& name) const {
    static const std::string none;
    const auto at = headers.find(name);
    return at == headers.end() ? none : at->second;
  }
  nlohmann::json json() const { return nlohmann::json::parse(body, nullptr, false); }
  /// The last path segment of a problem's type; empty when the body is no problem.
  std::string problem() const {
    const nlohmann::json document = json();
    if (header("content-type") != "application/problem+json" || !document.is_object()) return "";
    const std::string type = document.value("type", "");
    return type.substr(type.rfind('/') + 1);
  }
};

class RawClient {
 public:
  /// `from`: the client's own address, any of 127.0.0.0/8; 127.0.0.1 where none is given.
  explicit RawClient(std::uint16_t port, const std::string& from = "")
      : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (fd_ < 0) throw std::runtime_error("socket: " + std::string(std::strerror(errno)));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    if (!from.empty() && (::inet_pton(AF_INET, from.c_str(), &address.sin_addr) != 1 ||
                          ::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)) {
      ::close(fd_);
      throw std::runtime_error("bind: " + from);
    }
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      const int reason = errno;
      ::close(fd_);
      throw std::runtime_error("connect: " + std::string(std::strerror(reason)));
    }
    const int on = 1;
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  ~RawClient() {
    if (fd_ >= 0) ::close(fd_);
  }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// False when the server has closed.
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  /// A byte of urgent data (RFC 9293, section 3.8.5), beside the stream.
  bool send_urgent(char byte) { return ::send(fd_, &byte, 1, MSG_NOSIGNAL | MSG_OOB) == 1; }
  void half_close() { ::shutdown(fd_, SHUT_WR); }
  /// Closes with a reset instead of an orderly end.
  void reset() {
    const linger now{1, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
    ::close(fd_);
    fd_ = -1;
  }

  /// The next response, nothing when the server closed before a whole one arrived or `patience` ended.
  std::optional<Reply> receive(bool head_only = false,
                               std::chrono::seconds patience = std::chrono::seconds(30)) {
    const auto end = std::chrono::steady_clock::now() + patience;
    for (;;) {
      if (auto reply = take_reply(head_only)) return reply;
      if (!fill(end)) return std::nullopt;
    }
  }
  /// Whether this text has come, which stays to be received.
  bool receive_until(const std::string& text, std::chrono::seconds patience = std::chrono::seconds(30)) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (received_.find(text) == std::string::npos)
      if (!fill(end)) return false;
    return true;
  }
  /// Everything until the server closes (or `patience` ends, which sets timed_out).
  std::string receive_all(std::chrono::seconds patience = std::chrono::seconds(30)) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (fill(end)) {
    }
    return std::exchange(received_, {});
  }
  /// Reads at most `most` bytes, thrown away, and adds their number; false at the end.
  bool receive_some(std::size_t most, std::size_t& sum) {
    std::string bytes(most, '\0');
    const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
    if (n <= 0) return n < 0 && errno == EINTR;
    sum += static_cast<std::size_t>(n);
    return true;
  }
  bool timed_out() const { return timed_out_; }

 private:
  bool fill(std::chrono::steady_clock::time_point end) {
    for (;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      pollfd p{fd_, POLLIN, 0};
      const int ready = left.count() <= 0 ? 0 : ::poll(&p, 1, static_cast<int>(left.count()));
      if (ready < 0 && errno == EINTR) continue;
      if (ready <= 0) {
        timed_out_ = true;
        return false;
      }
      char bytes[131072];
      const ssize_t n = ::recv(fd_, bytes, sizeof bytes, 0);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      received_.append(bytes, static_cast<std::size_t>(n));
      return true;
    }
  }

  std::optional<Reply> take_reply(bool head_only) {
    const std::size_t end = received_.find("\r\n\r\n");
    if (end == std::string::npos) return std::nullopt;
    Reply reply;
    reply.status = std::atoi(received_.c_str() + 9);
    for (std::size_t at = received_.find("\r\n") + 2; at < end;) {
      const std::size_t stop = received_.find("\r\n", at), colon = received_.find(": ", at);
      std::string name = received_.substr(at, colon - at);
      for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      reply.headers[name] = received_.substr(colon + 2, stop - colon - 2);
      at = stop + 2;
    }
    const bool no_body = head_only || reply.status == 100 || reply.status == 204 || reply.status == 304;
    const std::size_t length =
        no_body ? 0 : std::strtoull(reply.header("content-length").c_str(), nullptr, 10);
    if (received_.size() < end + 4 + length) return std::nullopt;
    reply.body = received_.substr(end + 4, length);
    received_.erase(0, end + 4 + length);
    return reply;
  }

  int fd_;
  std::string received_;
  bool timed_out_ = false;
};

/// One request on a connection of its own.
inline Reply ask(std::uint16_t port, const std::string& method, const std::string& target,
                 const std::string& fields = "", const std::string& body = "", const std::string& from = "") {
  RawClient client(port, from);
  std::string request =
      method + " " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + fields;
  if (!body.empty() || method == "POST") request += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  client.send(request + "\r\n" + body);
  auto reply = client.receive(method == "HEAD");
  if (!reply) throw std::runtime_error("no reply to " + method + " " + target);
  record_exchange(method, target, reply->status, reply->headers, reply->body);
  return *reply;
}

}  // namespace fracture::test
