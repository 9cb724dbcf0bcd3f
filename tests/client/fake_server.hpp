// A server with raw sockets in the test's own process. It answers as the test says, including badly.
#pragma once

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <list>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace fracture::test {

struct FakeRequest {
  std::string method, target, head, body;
  int number = 0;      ///< among all requests, from 0
  int connection = 0;  ///< from 0
};

struct FakeReply {
  std::string bytes;    ///< sent unchanged
  bool close = false;   ///< then the connection is closed
  bool silent = false;  ///< sends nothing; the connection stays open until the client or the server closes
  static FakeReply answer(int status, const std::string& body, const std::string& headers = "") {
    return {"HTTP/1.1 " + std::to_string(status) + " Reason\r\n" + headers +
            "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body};
  }
};

class FakeServer {
 public:
  using Handler = std::function<FakeReply(const FakeRequest&)>;

  /// Listens on `port` of 127.0.0.1, or on a free one.
  explicit FakeServer(Handler handler, std::uint16_t port = 0) : handler_(std::move(handler)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int on = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listener_, 64) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("the fake server cannot listen");
    port_ = ntohs(address.sin_port);
    acceptor_ = std::thread([this] { accept(); });
  }
  ~FakeServer() {
    stopping_ = true;
    ::shutdown(listener_, SHUT_RDWR);
    acceptor_.join();
    ::close(listener_);
    {
      const std::lock_guard lock(mutex_);
      for (Conversation& c : conversations_) ::shutdown(c.fd, SHUT_RDWR);
    }
    for (Conversation& c : conversations_) {
      c.thread.join();
      ::close(c.fd);
    }
  }
  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;

  std::uint16_t port() const { return port_; }
  std::vector<FakeRequest> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }
  int connections() const { return connections_; }
  /// How many connections their clients closed while they waited for a silent answer.
  int closes() const { return closes_; }

 private:
  struct Conversation {
    int fd;
    std::thread thread;
  };

  void accept() {
    while (!stopping_) {
      const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (fd < 0) continue;
      const int on = 1;
      ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      const std::lock_guard lock(mutex_);
      const int number = connections_++;
      Conversation& conversation = conversations_.emplace_back(Conversation{fd, {}});
      conversation.thread = std::thread([this, fd, number] { serve(fd, number); });
    }
  }

  void serve(int fd, int connection) {
    std::string received;
    const auto fill = [&] {
      char bytes[65536];
      const ssize_t n = ::recv(fd, bytes, sizeof bytes, 0);
      if (n > 0) received.append(bytes, static_cast<std::size_t>(n));
      return n > 0;
    };
    while (!stopping_) {
      std::size_t end;
      while ((end = received.find("\r\n\r\n")) == std::string::npos)
        if (!fill()) return hang_up(fd);
      FakeRequest request;
      request.head = received.substr(0, end + 4);
      request.connection = connection;
      const std::size_t space = request.head.find(' ');
      request.method = request.head.substr(0, space);
      request.target = request.head.substr(space + 1, request.head.find(' ', space + 1) - space - 1);
      const std::size_t field = request.head.find("Content-Length: ");
      const std::size_t length =
          field == std::string::npos ? 0 : std::strtoul(request.head.c_str() + field + 16, nullptr, 10);
      while (received.size() < end + 4 + length)
        if (!fill()) return hang_up(fd);
      request.body = received.substr(end + 4, length);
      received.erase(0, end + 4 + length);
      {
        const std::lock_guard lock(mutex_);
        request.number = static_cast<int>(requests_.size());
        requests_.push_back(request);
      }
      const FakeReply reply = handler_(request);
      if (reply.silent) {
        while (fill()) {
        }
        ++closes_;
        return hang_up(fd);
      }
      std::size_t sent = 0;
      while (sent < reply.bytes.size()) {
        const ssize_t n = ::send(fd, reply.bytes.data() + sent, reply.bytes.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) return hang_up(fd);
        sent += static_cast<std::size_t>(n);
      }
      if (reply.close) return hang_up(fd);
    }
  }
  static void hang_up(int fd) { ::shutdown(fd, SHUT_RDWR); }

  Handler handler_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<bool> stopping_ = false;
  std::atomic<int> connections_ = 0, closes_ = 0;
  mutable std::mutex mutex_;
  std::vector<FakeRequest> requests_;
  std::list<Conversation> conversations_;
  std::thread acceptor_;
};

}  // namespace fracture::test
