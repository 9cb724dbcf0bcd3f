// A Redis server that is not trusted, and one that does not trust us: passwords, TLS, signatures, names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/digest/digest.hpp"
#include "tests/server/support/authority.hpp"
#include "tests/server/support/redis_process.hpp"

namespace fracture::test {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

[[maybe_unused]] const auto ignored = ::signal(SIGPIPE, SIG_IGN);  // as the server does

const std::string kKey = sha256("key").hex(), kOther = sha256("other").hex();
const Bytes kPayload(100'000, 7);
const CacheEntry kEntry{kKey, "m", kPayload};

/// Timeouts for a machine that is busy with other tests.
RedisConfig patient(const std::string& address) {
  RedisConfig config;
  config.address = address;
  config.connect_timeout = config.operation_timeout = std::chrono::seconds(20);
  return config;
}

FarmKeys keys_of(const std::string& text) { return *FarmKeys::parse(text); }

struct RedisTrust : testing::Test {
  TemporaryFolder folder;
  void SetUp() override {
    if (!find_program("redis-server")) GTEST_SKIP() << "there is no redis-server here";
  }
};

TEST_F(RedisTrust, WithoutItsUserAndPasswordEveryCallIsAFailure) {
  const RedisProcess process(folder,
                             "user default off\nuser farm on >correct-horse ~fracture:* +get +set +auth\n");
  RedisConfig config = patient(process.address());
  const auto stores = [&] {
    RedisCache cache(config);
    const bool stored = cache.insert(kEntry) && cache.find(kKey);
    EXPECT_EQ(cache.figures().failures, stored ? 0u : 1u);
    return stored;
  };
  EXPECT_FALSE(stores());
  config.user = "farm";
  config.password = "wrong";
  EXPECT_FALSE(stores());
  config.password = "correct-horse";
  EXPECT_TRUE(stores());
  config.user.clear();
  EXPECT_FALSE(stores()) << "the default user is off";
}

TEST_F(RedisTrust, APasswordWithoutAUserIsThatOfTheDefaultOne) {
  const RedisProcess process(folder, "requirepass correct-horse\n");
  RedisConfig config = patient(process.address());
  EXPECT_FALSE(RedisCache(config).insert(kEntry));
  config.password = "correct-horse";
  EXPECT_TRUE(RedisCache(config).insert(kEntry));
}

TEST_F(RedisTrust, WhatTheFarmHasNotSignedIsAMiss) {
  const RedisProcess process(folder);
  const auto with = [&](const FarmKeys& keys, int algorithm = 6) {
    RedisConfig config = patient(process.address());
    config.keys = keys;
    config.algorithm = algorithm;
    return config;
  };
  const std::string ours(64, 'a'), next(64, 'b'), theirs(64, 'c');
  RedisCache one(with(keys_of(ours))), other(with(keys_of(next + "\n" + ours))),
      stranger(with(keys_of(theirs))), unsigning(with({})), newer(with(keys_of(ours), 7));
  ASSERT_TRUE(one.insert(kEntry));
  EXPECT_TRUE(one.find(kKey));
  EXPECT_TRUE(other.find(kKey)) << "it signs with the next key and still takes this one";
  EXPECT_FALSE(newer.find(kKey));
  EXPECT_EQ(newer.figures().damaged, 1u);
  for (RedisCache* forger : {&stranger, &unsigning}) {
    ASSERT_TRUE(forger->insert(kEntry));
    EXPECT_TRUE(forger->find(kKey));
    const std::uint64_t damaged = one.figures().damaged;
    EXPECT_FALSE(one.find(kKey));
    EXPECT_EQ(one.figures().damaged, damaged + 1);
  }
  EXPECT_EQ(one.figures().failures, 0u);
}

TEST_F(RedisTrust, AnEntryUnderAnotherNameIsAMiss) {
  const RedisProcess process(folder);
  RedisConfig config = patient(process.address());
  config.keys = keys_of(std::string(64, 'a'));
  RedisCache cache(config);
  ASSERT_TRUE(cache.insert(kEntry));
  // A client that may write to Redis copies a value under another key. RENAME is answered like SET.
  NetworkAddress socket;
  auto& path = reinterpret_cast<sockaddr_un&>(socket.storage);
  path.sun_family = AF_UNIX;
  process.address().copy(path.sun_path, sizeof path.sun_path - 1);
  socket.size = sizeof path;
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  const auto connection = RedisConnection::open(socket, "", nullptr, 1u << 20, deadline);
  ASSERT_TRUE(connection);
  ASSERT_TRUE(connection->ask({"RENAME", "fracture:" + kKey, "fracture:" + kOther}, deadline));
  EXPECT_FALSE(cache.find(kOther));
  EXPECT_EQ(cache.figures().damaged, 1u);
}

TEST_F(RedisTrust, TlsChecksTheAuthorityAndTheNameAndShowsOurOwnCertificate) {
  if (!find_program("openssl")) GTEST_SKIP() << "there is no openssl here";
  const Authority ours(folder, "ours"), theirs(folder, "theirs");
  ours.sign("redis", "IP:127.0.0.1,DNS:localhost");
  ours.sign("elsewhere", "DNS:elsewhere.example");
  ours.sign("server", "DNS:server");
  const auto tls_lines = [&](const std::string& certificate, std::uint16_t port) {
    return "port 0\ntls-port " + std::to_string(port) +
           "\nbind 127.0.0.1\ntls-auth-clients yes\ntls-cert-file " + ours.certificate(certificate) +
           "\ntls-key-file " + ours.key(certificate) + "\ntls-ca-cert-file " + ours.certificate("ours") +
           "\n";
  };
  const std::uint16_t port = free_port();
  const RedisProcess process(folder, tls_lines("redis", port), port);
  RedisConfig config = patient(process.address());
  config.tls = {true, ours.certificate("ours"), ours.certificate("server"), ours.key("server")};
  const auto stores = [](const RedisConfig& with) {
    RedisCache cache(with);
    const bool stored = cache.insert(kEntry) && cache.find(kKey);
    EXPECT_EQ(cache.figures().failures, stored ? 0u : 1u);
    return stored;
  };
  EXPECT_TRUE(stores(config));
  RedisConfig wrong = config;
  wrong.tls.ca_file = theirs.certificate("theirs");
  EXPECT_FALSE(stores(wrong)) << "another authority";
  wrong = config;
  wrong.tls.cert_file.clear();
  EXPECT_FALSE(stores(wrong)) << "a client that shows no certificate";
  wrong = config;
  wrong.tls.on = false;
  EXPECT_FALSE(stores(wrong)) << "no TLS at all";
  wrong = config;
  wrong.tls.ca_file = folder / "absent";
  EXPECT_FALSE(stores(wrong)) << "files that cannot be read are no reason to trust anybody";
  EXPECT_THAT(RedisTls::load(wrong.tls).error().detail, HasSubstr("absent"));

  const std::uint16_t other_port = free_port();
  const TemporaryFolder other_folder;
  const RedisProcess elsewhere(other_folder, tls_lines("elsewhere", other_port), other_port);
  RedisConfig misled = config;
  misled.address = elsewhere.address();
  EXPECT_FALSE(stores(misled)) << "a certificate of another name";
}

TEST_F(RedisTrust, TlsThatSaysNothingIsGivenUp) {
  // Reads the TLS greeting and never answers.
  const Impostor silent([](int fd) {
    char byte = 0;
    while (::recv(fd, &byte, 1, 0) > 0) {
    }
  });
  RedisConfig config = config_of(silent);
  config.tls.on = true;
  RedisCache cache(config);
  EXPECT_FALSE(cache.find(kKey));
  EXPECT_EQ(cache.figures().failures, 1u);
}

TEST_F(RedisTrust, ANameIsResolvedBehindTheCallersBack) {
  const std::uint16_t port = free_port();
  const RedisProcess process(folder, "port " + std::to_string(port) + "\nbind 127.0.0.1\n", port);
  RedisCache cache(patient("localhost:" + std::to_string(port)));
  EXPECT_TRUE(eventually(kPatience, "localhost to be resolved", [&] { return cache.insert(kEntry); }));
  EXPECT_TRUE(cache.find(kKey));
  EXPECT_EQ(cache.figures().failures, 0u) << "before that it was not asked, which is no failure";

  // RFC 6761: the top-level domain "invalid" never resolves.
  RedisCache nowhere(patient("redis.invalid:6379"));
  EXPECT_TRUE(eventually(kPatience, "a name to be found to be none", [&] {
    EXPECT_FALSE(nowhere.find(kKey));
    return nowhere.figures().failures > 0;
  }));
}

}  // namespace
}  // namespace fracture::test
