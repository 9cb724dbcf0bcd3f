#include "tests/server/support/raw_client.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "tests/server/support/record.hpp"

namespace fracture::test {

const std::string& Reply::header(const std::string& name) const {
  static const std::string none;
  const auto at = headers.find(name);
  return at == headers.end() ? none : at->second;
}
nlohmann::json Reply::json() const { return nlohmann::json::parse(body, nullptr, false); }
std::string Reply::problem() const {
  const nlohmann::json document = json();
  if (header("content-type") != "application/problem+json" || !document.is_object()) return "";
  const std::string type = document.value("type", "");
  return type.substr(type.rfind('/') + 1);
}

RawClient::RawClient(std::uint16_t port, const std::string& from)
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
RawClient::~RawClient() {
  if (fd_ >= 0) ::close(fd_);
}

bool RawClient::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}
bool RawClient::send_urgent(char byte) { return ::send(fd_, &byte, 1, MSG_NOSIGNAL | MSG_OOB) == 1; }
void RawClient::half_close() { ::shutdown(fd_, SHUT_WR); }
void RawClient::reset() {
  const linger now{1, 0};
  ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
  ::close(fd_);
  fd_ = -1;
}

std::optional<Reply> RawClient::receive(bool head_only, std::chrono::seconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  for (;;) {
    if (auto reply = take_reply(head_only)) return reply;
    if (!fill(end)) return std::nullopt;
  }
}
bool RawClient::receive_until(const std::string& text, std::chrono::seconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (received_.find(text) == std::string::npos)
    if (!fill(end)) return false;
  return true;
}
std::string RawClient::receive_all(std::chrono::seconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (fill(end)) {
  }
  return std::exchange(received_, {});
}
bool RawClient::receive_some(std::size_t most, std::size_t& sum) {
  std::string bytes(most, '\0');
  const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
  if (n <= 0) return n < 0 && errno == EINTR;
  sum += static_cast<std::size_t>(n);
  return true;
}
bool RawClient::fill(std::chrono::steady_clock::time_point end) {
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

std::optional<Reply> RawClient::take_reply(bool head_only) {
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
  const std::size_t length = no_body ? 0 : std::strtoull(reply.header("content-length").c_str(), nullptr, 10);
  if (received_.size() < end + 4 + length) return std::nullopt;
  reply.body = received_.substr(end + 4, length);
  received_.erase(0, end + 4 + length);
  return reply;
}

Reply ask(std::uint16_t port, const std::string& method, const std::string& target, const std::string& fields,
          const std::string& body, const std::string& from) {
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
