#include "server/cache/redis_cache.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <thread>

#include "common/digest/digest.hpp"
#include "tests/server/support/redis_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture {
namespace {

using test::config_of;
using test::Impostor;
using test::RedisProcess;
using test::say;
using test::TemporaryFolder;
using Bytes = std::vector<std::uint8_t>;

[[maybe_unused]] const auto ignored = ::signal(SIGPIPE, SIG_IGN);  // as the server does

const std::string kKey = sha256("key").hex();

struct Redis : testing::Test {
  TemporaryFolder folder;
  RedisProcess process{folder};
  RedisConfig config;
  Bytes payload = Bytes(100'000, 7);
  CacheEntry entry{kKey, "m", payload};

  void SetUp() override {
    if (!process.running()) GTEST_SKIP() << "there is no redis-server here";
    config.address = process.address();
    config.operation_timeout =
        std::chrono::milliseconds(2'000);  // enough for a busy machine; shorter where the time matters
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
  config.max_value_bytes = 50;  // less than 100,000 equal bytes take after compression
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
  process.start();
  EXPECT_TRUE(test::eventually(test::kPatience, "the breaker to try again", [&] {
    EXPECT_FALSE(cache.find(kKey)) << "it lives in memory only";
    return !cache.figures().open;
  }));
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

TEST(RedisImpostor, NonsenseIsAMiss) {
  for (const std::string& text :
       {std::string("HTTP/1.1 200 OK\r\n\r\n"), std::string("$-7\r\n"), std::string("$999999999999\r\nx"),
        std::string("*1000000000\r\n"), std::string(100'000, '\0'), std::string("+OK\r\n"),
        std::string(":1\r\n"), std::string("$5\r\nhello\r\n"), std::string("-ERR no\r\n"),
        std::string("*2\r\n$1\r\na\r\n$1\r\nb\r\n"),
        // A zstd frame that claims to hold 2^60 bytes.
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
    // One byte every 20 ms: each read is within its timeout, but the whole answer would take half an hour.
    for (int i = 0; i < 100'000 && !self->stopping; ++i) {
      if (::send(fd, "x", 1, MSG_NOSIGNAL) <= 0) break;
      ::usleep(20'000);  // pause: an impostor that is slow on purpose
    }
  });
  self = &impostor;
  RedisCache cache(config_of(impostor));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(cache.find(kKey));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_EQ(cache.figures().failures, 1u);
}

TEST(RedisImpostor, AnAnswerWithoutEndIsGivenUpAtTheLargestValue) {
  std::size_t taken = 0;
  {
    Impostor impostor([&](int fd) {
      say(fd, "$1000000000\r\n");
      const std::string block(64u << 10, 'x');
      ssize_t sent = 0;
      while ((sent = ::send(fd, block.data(), block.size(), MSG_NOSIGNAL)) > 0)
        taken += static_cast<std::size_t>(sent);
    });
    RedisConfig config = config_of(impostor);
    config.operation_timeout = std::chrono::seconds(20);  // so that the size ends it, not the time
    config.max_value_bytes = 1u << 20;
    RedisCache cache(config);
    EXPECT_FALSE(cache.find(kKey));
    EXPECT_EQ(cache.figures().failures, 1u);
  }
  EXPECT_LT(taken, 32u << 20) << "the value, and what two sockets hold";
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
