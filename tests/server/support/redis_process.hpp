// A real redis-server, and an impostor that only pretends to be one.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/cache/redis_cache.hpp"
#include "tests/server/support/child_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

/// A redis-server with its files in the folder. It listens on a socket there, or on a port if the additional
/// configuration asks for one.
class RedisProcess {
 public:
  explicit RedisProcess(const TemporaryFolder& folder, const std::string& configuration = "",
                        std::uint16_t port = 0)
      : folder_(folder), port_(port) {
    folder.write("redis.conf", "save \"\"\nappendonly no\nloglevel warning\ndir " + folder.path + "\n" +
                                   (port == 0 ? "port 0\nunixsocket " + address() + "\n" : "") +
                                   configuration);
    start();
  }
  ~RedisProcess() { stop(); }
  void start() {
    const auto program = find_program("redis-server");
    if (!program) return;
    process_ = std::make_unique<ChildProcess>(std::vector<std::string>{*program, folder_ / "redis.conf"},
                                              folder_ / "redis.log");
    require_eventually(kPatience, "redis-server to listen", [&] {
      if (!process_->alive()) throw std::runtime_error("redis-server: " + read_file(folder_ / "redis.log"));
      return accepts();
    });
  }
  void stop() {
    process_.reset();
    if (port_ == 0) ::unlink(address().c_str());
  }
  void pause() { process_->signal(SIGSTOP); }
  bool running() const { return process_ && accepts(); }
  std::string address() const {
    return port_ == 0 ? folder_ / "redis.sock" : "127.0.0.1:" + std::to_string(port_);
  }

 private:
  /// The socket file exists before anybody listens on it.
  bool accepts() const {
    sockaddr_storage storage{};
    if (port_ == 0) {
      auto& path = reinterpret_cast<sockaddr_un&>(storage);
      path.sun_family = AF_UNIX;
      address().copy(path.sun_path, sizeof path.sun_path - 1);
    } else {
      auto& ip = reinterpret_cast<sockaddr_in&>(storage);
      ip.sin_family = AF_INET;
      ip.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      ip.sin_port = htons(port_);
    }
    const int fd = ::socket(storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const socklen_t size = port_ == 0 ? sizeof(sockaddr_un) : sizeof(sockaddr_in);
    const bool connected = ::connect(fd, reinterpret_cast<const sockaddr*>(&storage), size) == 0;
    ::close(fd);
    return connected;
  }

  const TemporaryFolder& folder_;
  const std::uint16_t port_;
  std::unique_ptr<ChildProcess> process_;
};

/// Answers every connection as it is told to, whatever was asked.
class Impostor {
 public:
  explicit Impostor(std::function<void(int)> answer) : answer_(std::move(answer)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address);
    ::listen(listener_, 16);
    socklen_t size = sizeof address;
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      for (int fd; (fd = ::accept(listener_, nullptr, nullptr)) >= 0; ::close(fd)) {
        char question[4096];
        if (::recv(fd, question, sizeof question, 0) > 0) answer_(fd);
      }
    });
  }
  ~Impostor() {
    stopping = true;
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  std::atomic<bool> stopping{false};
  int port = 0;

 private:
  std::function<void(int)> answer_;
  int listener_ = -1;
  std::thread thread_;
};

inline RedisConfig config_of(const Impostor& impostor) {
  RedisConfig config;
  config.address = "127.0.0.1:" + std::to_string(impostor.port);
  return config;
}

inline void say(int fd, const std::string& text) {
  (void)!::send(fd, text.data(), text.size(), MSG_NOSIGNAL);
}

}  // namespace fracture::test
