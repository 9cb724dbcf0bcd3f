#include "server/cache/redis_cache.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "common/base/digest.hpp"
#include "tests/server/temporary_folder.hpp"

extern char** environ;

namespace fracture {
namespace {

using test::TemporaryFolder;
using Bytes = std::vector<std::uint8_t>;

[[maybe_unused]] const auto ignored = ::signal(SIGPIPE, SIG_IGN);  // as the server does

const std::string kKey = sha256("key").hex();

/// A redis-server on a socket in a folder of its own.
class RedisProcess {
 public:
  explicit RedisProcess(const std::string& folder) : socket(folder + "/redis.sock") { start(folder); }
  ~RedisProcess() { stop(); }
  void start(const std::string& folder) {
    std::vector<std::string> arguments = {
        "redis-server",       "--port", "0",     "--unixsocket", socket,       "--save",  "",
        "--appendonly",       "no",     "--dir", folder,         "--loglevel", "warning", "--logfile",
        folder + "/redis.log"};
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    if (::posix_spawnp(&pid_, argv[0], nullptr, nullptr, argv.data(), environ) != 0) {
      pid_ = 0;
      return;
    }
    for (int i = 0; i < 2000 && !accepts(); ++i) ::usleep(10'000);
  }
  void stop() {
    if (pid_ == 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = 0;
    ::unlink(socket.c_str());
  }
  void pause() { ::kill(pid_, SIGSTOP); }
  bool running() const { return pid_ != 0 && accepts(); }
  const std::string socket;

 private:
  /// The file is there before anybody listens on it.
  bool accepts() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socket.copy(address.sun_path, sizeof address.sun_path - 1);
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool connected = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    ::close(fd);
    return connected;
  }

  pid_t pid_ = 0;
};

struct Redis : testing::Test {
  TemporaryFolder folder;
  RedisProcess process{folder.path};
  RedisConfig config;
  Bytes payload = Bytes(100'000, 7);
  CacheEntry entry{kKey, "m", payload};

  void SetUp() override {
    if (!process.running()) GTEST_SKIP() << "there is no redis-server here";
    config.address = process.socket;
    config.operation_timeout =
        std::chrono::milliseconds(2'000);  // of a busy machine; shorter where it matters
    config.connect_timeout = std::chrono::milliseconds(2'000);
  }
};

TEST_F(Redis, WhatOneServerStoresAnotherFinds) {
  RedisCache one(config), other(config);
  EXPECT_FALSE(other.find(kKey));
  ASSERT_TRUE(one.insert(entry));
  const auto found = other.find(kKey);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->entry.metadata, "m");
  EXPECT_TRUE(
      std::equal(payload.begin(), payload.end(), found->entry.payload.begin(), found->entry.payload.end()));
  EXPECT_EQ(other.figures().hits, 1u);
  EXPECT_EQ(other.figures().misses, 1u);
  EXPECT_EQ(one.figures().failures + other.figures().failures, 0u);
}

TEST_F(Redis, AValueOverTheLimitIsNotSent) {
  config.max_value_bytes = 50;  // 100,000 equal bytes are compressed to more
  RedisCache cache(config);
  EXPECT_FALSE(cache.insert(entry));
  EXPECT_FALSE(cache.find(kKey));
  EXPECT_EQ(cache.figures().failures, 0u);
}

TEST_F(Redis, WhenItIsDownEveryCallIsAMissAndSoonNotEvenTried) {
  RedisCache cache(config);
  ASSERT_TRUE(cache.insert(entry));
  process.stop();
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(cache.find(kKey));
  EXPECT_FALSE(cache.insert(entry));
  const RedisFigures figures = cache.figures();
  EXPECT_TRUE(figures.open);
  EXPECT_EQ(figures.failures, 3u) << "the breaker opens at the third";
  EXPECT_GE(figures.skipped, 17u);
}

TEST_F(Redis, WhenItIsBackItIsFoundAgain) {
  RedisCache cache(config);
  ASSERT_TRUE(cache.insert(entry));
  process.stop();
  for (int i = 0; i < 5; ++i) cache.find(kKey);
  EXPECT_TRUE(cache.figures().open);
  process.start(folder.path);
  std::this_thread::sleep_for(CircuitBreaker::kShortest + std::chrono::milliseconds(100));
  EXPECT_FALSE(cache.find(kKey)) << "it lives in memory only";
  EXPECT_FALSE(cache.figures().open);
  EXPECT_TRUE(cache.insert(entry));
  EXPECT_TRUE(cache.find(kKey));
}

TEST_F(Redis, WhenItHangsCallsEndAndTheBreakerOpens) {
  config.operation_timeout = std::chrono::milliseconds(50);
  RedisCache cache(config);
  process.pause();
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(cache.find(kKey));
  EXPECT_EQ(cache.figures().failures, 3u);
  EXPECT_EQ(cache.figures().skipped, 7u);
}

/// Answers every connection with what it is told to, whatever was asked.
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

RedisConfig config_of(const Impostor& impostor) {
  RedisConfig config;
  config.address = "127.0.0.1:" + std::to_string(impostor.port);
  return config;
}

void say(int fd, const std::string& text) { (void)!::send(fd, text.data(), text.size(), MSG_NOSIGNAL); }

TEST(RedisImpostor, NonsenseIsAMiss) {
  for (const std::string& text :
       {std::string("HTTP/1.1 200 OK\r\n\r\n"), std::string("$-7\r\n"), std::string("$999999999999\r\nx"),
        std::string("*1000000000\r\n"), std::string(100'000, '\0'), std::string("+OK\r\n"),
        std::string(":1\r\n"), std::string("$5\r\nhello\r\n"), std::string("-ERR no\r\n"),
        std::string("*2\r\n$1\r\na\r\n$1\r\nb\r\n"),
        // A zstd frame that says it holds 2^60 bytes.
        std::string("$13\r\n\x28\xb5\x2f\xfd\xe0\0\0\0\0\0\0\0\x10\r\n", 20)}) {
    Impostor impostor([&](int fd) { say(fd, text); });
    RedisCache cache(config_of(impostor));
    EXPECT_FALSE(cache.find(kKey)) << text.substr(0, 20);
    EXPECT_EQ(cache.figures().hits, 0u);
    EXPECT_EQ(cache.figures().failures + cache.figures().damaged, 1u) << text.substr(0, 20);
  }
}

TEST(RedisImpostor, AnAnswerThatTricklesIsGivenUpAtTheDeadlineOfTheWhole) {
  Impostor* self = nullptr;
  Impostor impostor([&](int fd) {
    say(fd, "$100000\r\n");
    // A byte every 20 ms is within any timeout of a single read, for half an hour.
    for (int i = 0; i < 100'000 && !self->stopping; ++i) {
      if (::send(fd, "x", 1, MSG_NOSIGNAL) <= 0) break;
      ::usleep(20'000);
    }
  });
  self = &impostor;
  RedisCache cache(config_of(impostor));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(cache.find(kKey));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_EQ(cache.figures().failures, 1u);
}

TEST(CircuitBreakerTest, OneTriesAfterAWhileAndEachFailureDoublesIt) {
  using std::chrono::milliseconds;
  CircuitBreaker breaker;
  CircuitBreaker::Clock::time_point now{};
  for (int i = 0; i < CircuitBreaker::kFailures; ++i) {
    EXPECT_TRUE(breaker.allows(now));
    breaker.failure(now);
  }
  EXPECT_FALSE(breaker.allows(now + milliseconds(999)));
  now += milliseconds(1000);
  EXPECT_TRUE(breaker.allows(now));
  EXPECT_FALSE(breaker.allows(now)) << "only one";
  breaker.failure(now);
  EXPECT_FALSE(breaker.allows(now + milliseconds(1999)));
  now += milliseconds(2000);
  EXPECT_TRUE(breaker.allows(now));
  breaker.success();
  EXPECT_TRUE(breaker.allows(now));
  EXPECT_FALSE(breaker.open());
}

}  // namespace
}  // namespace fracture
