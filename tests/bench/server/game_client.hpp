// A client like that of a game: a keep-alive connection, and a buffer that is received into and read in
// place. It adds only the cost of the kernel's copy to a measurement; the tests' own client copies answers
// several times.
#pragma once

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <charconv>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace fracture::bench {

class GameClient {
 public:
  /// Views into the client's buffer, valid until the next request.
  struct Answer {
    int status = 0;
    std::string_view head, body;
    std::chrono::steady_clock::time_point first_byte;
  };

  explicit GameClient(std::uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (fd_ < 0 || ::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("cannot connect to port " + std::to_string(port));
    const int on = 1;
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    buffer_.resize(1 << 22);
  }
  ~GameClient() {
    if (fd_ >= 0) ::close(fd_);
  }
  GameClient(const GameClient&) = delete;
  GameClient& operator=(const GameClient&) = delete;

  /// Throws std::runtime_error if the server closes or answers without a Content-Length.
  Answer ask(std::string_view request) {
    if (::send(fd_, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
      throw std::runtime_error("the request was not taken");
    std::size_t used = 0;
    Answer answer;
    std::size_t end = std::string_view::npos;
    while (end == std::string_view::npos) {
      used += receive(used, 0);
      if (answer.first_byte == std::chrono::steady_clock::time_point{})
        answer.first_byte = std::chrono::steady_clock::now();
      end = text(used).find("\r\n\r\n");
    }
    const std::size_t head = end + 4;
    std::size_t length = number(text(end), "\r\nContent-Length: ");
    if (head + length > buffer_.size()) buffer_.resize(head + length);
    while (used < head + length) used += receive(used, head + length);
    answer.head = text(head);
    answer.body = text(used).substr(head);
    answer.status = static_cast<int>(number(answer.head, "HTTP/1.1 "));
    return answer;
  }

 private:
  std::string_view text(std::size_t size) const { return {buffer_.data(), size}; }
  static std::size_t number(std::string_view text, std::string_view after) {
    const std::size_t at = text.find(after);
    std::size_t value = 0;
    if (at == std::string_view::npos) throw std::runtime_error("an answer without " + std::string(after));
    std::from_chars(text.data() + at + after.size(), text.data() + text.size(), value);
    return value;
  }
  /// Receives the bytes that have arrived, up to the end of the message if that is known.
  std::size_t receive(std::size_t used, std::size_t message) {
    const std::size_t room = (message ? message : buffer_.size()) - used;
    const ssize_t n = ::recv(fd_, buffer_.data() + used, room, message ? MSG_WAITALL : 0);
    if (n <= 0) throw std::runtime_error("the server closed the connection");
    return static_cast<std::size_t>(n);
  }

  int fd_;
  std::vector<char> buffer_;
};

}  // namespace fracture::bench
