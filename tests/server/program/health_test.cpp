// fracture-server health exits with 0 if the server answers 200, with 2 for a wrong command line, and with 1
// for every other reason. It names the reason.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

#include "tests/server/support/child_process.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// Returns the exit code and the whole standard error.
std::pair<int, std::string> health(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "health");
  Process process(std::move(arguments));
  std::string errors;
  for (std::string line = process.error_line(); !line.empty(); line = process.error_line()) errors += line;
  return {process.wait(), errors};
}

std::string url(std::uint16_t port, const std::string& path = "") {
  return "http://127.0.0.1:" + std::to_string(port) + path;
}

TEST(Health, AServerIsAliveAndReadyUntilItDrains) {
  ServeProcess server({"--drain-delay", "600"});
  EXPECT_EQ(health({url(server.admin_port)}), std::pair(0, std::string()));
  EXPECT_EQ(health({url(server.admin_port), "--ready"}).first, 0);
  EXPECT_EQ(health({url(server.port, "/limits")}).first, 0);
  const auto [code, error] = health({url(server.port, "/nothing")});
  EXPECT_EQ(code, 1);
  EXPECT_NE(error.find("/nothing answered 404"), std::string::npos) << error;
  const auto [public_code, public_error] = health({url(server.port)});
  EXPECT_EQ(public_code, 1);
  EXPECT_NE(public_error.find("not an admin listener. Use the --admin-port (8081"), std::string::npos)
      << public_error;

  server.signal(SIGTERM);
  require_eventually(kPatience, "the server to take the signal",
                     [&] { return ask(server.admin_port, "GET", "/readyz").status != 200; });
  EXPECT_EQ(health({url(server.admin_port), "--ready"}).first, 1);
  EXPECT_EQ(health({url(server.admin_port)}).first, 0) << "a draining server is alive";
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
  const auto [gone_code, gone_error] = health({url(server.admin_port)});
  EXPECT_EQ(gone_code, 1);
  EXPECT_NE(gone_error.find("Is the server running"), std::string::npos) << gone_error;
}

TEST(Health, WithoutAUrlTheServersOwnSettingsSayWhere) {
  ServeProcess server;
  TemporaryFolder folder;
  const std::string file = folder.write(
      "fracture.toml", "admin-address = \"0.0.0.0\"\nadmin-port = " + std::to_string(server.admin_port) +
                           "\ninsecure-bind = true\n");
  EXPECT_EQ(health({"--config", file}), std::pair(0, std::string()));

  const auto [missing, missing_error] = health({"--config", folder / "missing.toml"});
  EXPECT_EQ(missing, 2);
  EXPECT_NE(missing_error.find("missing.toml"), std::string::npos) << missing_error;
  const auto [any, any_error] = health({"--config", folder.write("any.toml", "admin-port = 0\n")});
  EXPECT_EQ(any, 2);
  EXPECT_NE(any_error.find("admin-port is 0"), std::string::npos) << any_error;
}

TEST(Health, AServerMayListenOnAnIpv6Address) {
  const int fd = ::socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in6 loopback{};
  loopback.sin6_family = AF_INET6;
  loopback.sin6_addr = in6addr_loopback;
  const bool possible = fd >= 0 && ::bind(fd, reinterpret_cast<sockaddr*>(&loopback), sizeof loopback) == 0;
  ::close(fd);
  if (!possible) GTEST_SKIP() << "there is no IPv6 here";
  ServeProcess server({"--address", "::1", "--admin-address", "::1"});
  for (const std::uint16_t port : {server.port, server.admin_port})
    EXPECT_EQ(health({"http://[::1]:" + std::to_string(port) + (port == server.port ? "/limits" : "")}),
              std::pair(0, std::string()));
}

TEST(Health, WhateverCannotBeAskedIsNotHealthy) {
  for (const char* wrong : {"127.0.0.1:8081", "https://127.0.0.1", "http://", "http://:80", "http://a:0",
                            "http://a:65536", "http://a:b", "http://[::1", "http://[::1]x", "http://a/b c"}) {
    const auto [code, error] = health({wrong});
    EXPECT_EQ(code, 2) << wrong;
    EXPECT_NE(error.find("must be http://host[:port][/path]"), std::string::npos) << wrong << ": " << error;
  }
  EXPECT_EQ(health({"--nonsense"}).first, 2);
  EXPECT_EQ(health({"http://127.0.0.1", "--timeout", "0"}).first, 2);
}

// A listener that accepts (by its backlog) and never answers.
TEST(Health, AServerThatHangsIsNotHealthy) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(fd, 8), 0);
  ASSERT_EQ(::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const auto [code, error] = health({url(ntohs(address.sin_port)), "--timeout", "1"});
  EXPECT_EQ(code, 1);
  EXPECT_NE(error.find("no answer within 1 s"), std::string::npos) << error;
  ::close(fd);
}

}  // namespace
}  // namespace fracture::test
