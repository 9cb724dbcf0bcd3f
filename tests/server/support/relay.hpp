// A relay in front of a server, and ports on which no process listens.
#pragma once

#include <chrono>
#include <stdexcept>
#include <string>

#include "tests/client/fake_server.hpp"
#include "tests/server/support/raw_client.hpp"

namespace fracture::test {

/// Passes a request on. Returns the server's whole answer, after which the connection is closed. If there is
/// no server or it dies, returns the bytes received so far.
inline FakeReply pass_on(const FakeRequest& request, std::uint16_t server_port) {
  try {
    RawClient client(server_port);
    std::string head = request.head;
    head.insert(head.size() - 2, "Connection: close\r\n");
    client.send(head + request.body);
    return {client.receive_all(std::chrono::hours(1)), true};
  } catch (const std::runtime_error&) {
    return {"", true};
  }
}

/// A port of 127.0.0.1 that refuses connections for as long as this object lives, because no other process
/// can listen on it.
class DeafPort {
 public:
  DeafPort() : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(fd_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("no free port");
    port = ntohs(address.sin_port);
  }
  ~DeafPort() { ::close(fd_); }
  DeafPort(const DeafPort&) = delete;
  DeafPort& operator=(const DeafPort&) = delete;
  std::uint16_t port = 0;

 private:
  int fd_;
};

}  // namespace fracture::test
