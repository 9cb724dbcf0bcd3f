// A Redis that is slow to write: it answers a SET only when the test allows it. A GET finds what was written before.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/eventually.hpp"

namespace fracture::test {

class SlowRedis {
 public:
  /// `path`: of the socket on which it listens.
  explicit SlowRedis(const std::string& path) : listener_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener_, 16) != 0)
      throw std::runtime_error("cannot listen on " + path);
    acceptor_ = std::thread([this] {
      for (int fd; (fd = ::accept(listener_, nullptr, nullptr)) >= 0;) {
        std::FILE* const stream = ::fdopen(fd, "r");
        const std::lock_guard lock(mutex_);
        streams_.push_back(stream);
        threads_.emplace_back([this, stream] { serve(stream); });
      }
    });
  }
  ~SlowRedis() {
    open();
    ::shutdown(listener_, SHUT_RDWR);
    acceptor_.join();
    for (std::FILE* stream : streams_) ::shutdown(::fileno(stream), SHUT_RDWR);
    for (std::thread& thread : threads_) thread.join();
    for (std::FILE* stream : streams_) std::fclose(stream);
    ::close(listener_);
  }
  SlowRedis(const SlowRedis&) = delete;
  SlowRedis& operator=(const SlowRedis&) = delete;

  /// From now on, it answers every SET at once.
  void open() { open_ = true; }
  /// From now on, it answers no SET.
  void close() { open_ = false; }
  /// The keys of all SET commands that have arrived, in their order.
  std::vector<std::string> written() const {
    const std::lock_guard lock(mutex_);
    return written_;
  }

 private:
  /// Reads a number after its mark ('*' or '$'); -1 at the end of the connection.
  static long number(std::FILE* stream) {
    std::string line;
    for (int c; (c = std::fgetc(stream)) != '\n'; line += static_cast<char>(c))
      if (c == EOF) return -1;
    return std::stol(line.substr(1));
  }
  /// Reads a command as its words; empty at the end of the connection.
  static std::vector<std::string> command(std::FILE* stream) {
    std::vector<std::string> words;
    for (long left = number(stream); left > 0; --left) {
      const long size = number(stream);
      if (size < 0) return {};
      std::string word(static_cast<std::size_t>(size) + 2, '\0');
      if (std::fread(word.data(), 1, word.size(), stream) != word.size()) return {};
      words.push_back(word.substr(0, word.size() - 2));
    }
    return words;
  }
  std::string reply_to(const std::vector<std::string>& words) {
    const std::lock_guard lock(mutex_);
    if (words[0] == "SET") {
      values_[words.at(1)] = words.at(2);
      return "+OK\r\n";
    }
    const auto value = values_.find(words.at(1));
    if (value == values_.end()) return "$-1\r\n";
    return "$" + std::to_string(value->second.size()) + "\r\n" + value->second + "\r\n";
  }
  void serve(std::FILE* stream) {
    for (std::vector<std::string> words; words = command(stream), !words.empty();) {
      if (words[0] == "SET") {
        {
          const std::lock_guard lock(mutex_);
          written_.push_back(words.at(1).substr(std::string("fracture:").size()));
        }
        EXPECT_TRUE(eventually(kPatience, "the test to open this Redis", [this] { return open_.load(); }));
      }
      const std::string reply = reply_to(words);
      (void)!::send(::fileno(stream), reply.data(), reply.size(), MSG_NOSIGNAL);
    }
  }

  const int listener_;
  mutable std::mutex mutex_;
  std::atomic<bool> open_{false};
  std::vector<std::string> written_;
  std::map<std::string, std::string> values_;
  std::vector<std::FILE*> streams_;
  std::vector<std::thread> threads_;
  std::thread acceptor_;
};

}  // namespace fracture::test
