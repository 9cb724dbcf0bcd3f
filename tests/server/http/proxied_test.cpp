// Clients behind a trusted proxy take turns separately. Other senders of such headers are not believed.
#include <gtest/gtest.h>

#include <atomic>
#include <mutex>

#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

const std::string kBody = "a mesh";

std::string post_of(const std::string& mesh, const std::string& fields) {
  return "POST /fracture HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\n" + fields +
         "Content-Length: " + std::to_string(mesh.size()) + "\r\n\r\n" + mesh;
}

TestServerOptions behind_a_proxy(bool trusted) {
  TestServerOptions options;
  options.threads = 1;
  if (trusted) options.server.proxies.add("127.0.0.0/8");
  return options;
}

/// Ten meshes of one client and then one of another client wait for the only thread. Returns the position at
/// which the other client's mesh is imported.
std::size_t place_of_the_second_client(bool trusted, bool proxy_protocol) {
  TestServer server(behind_a_proxy(trusted));
  std::atomic<bool> open{false};
  std::mutex mutex;
  std::vector<std::string> order;
  server.control->import = [&](std::string_view mesh) -> Expected<Mesh> {
    require_eventually(kPatience, "the test to let the import go on", [&] { return open.load(); });
    const std::lock_guard lock(mutex);
    order.emplace_back(mesh);
    return Mesh{};
  };
  std::vector<std::unique_ptr<RawClient>> clients;
  const auto ask = [&](const std::string& mesh, const std::string& address) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send(proxy_protocol
                             ? "PROXY TCP4 " + address + " 192.0.2.2 1234 80\r\n" + post_of(mesh, "")
                             : post_of(mesh, "Forwarded: for=" + address + "\r\n"));
    EXPECT_TRUE(eventually(kPatience, "it to be queued",
                           [&] { return server.pool.queued() + server.pool.running() == clients.size(); }));
  };
  for (int k = 0; k < 10; ++k) ask("first " + std::to_string(k), "198.51.100.1");
  ask("second", "198.51.100.2");
  open = true;
  for (const auto& client : clients) EXPECT_EQ(client->receive()->status, 200);
  return static_cast<std::size_t>(std::find(order.begin(), order.end(), "second") - order.begin());
}

TEST(Proxied, EveryClientOfATrustedProxyHasItsOwnTurn) {
  EXPECT_LE(place_of_the_second_client(/*trusted=*/true, /*proxy_protocol=*/false), 2u);
  EXPECT_LE(place_of_the_second_client(true, true), 2u);
}

TEST(Proxied, NobodyElseIsBelieved) {
  EXPECT_EQ(place_of_the_second_client(/*trusted=*/false, /*proxy_protocol=*/false), 10u);
  TestServer server;
  RawClient client(server.port());
  client.send("PROXY TCP4 198.51.100.1 192.0.2.2 1234 80\r\n" + post_of(kBody, ""));
  EXPECT_EQ(client.receive()->status, 400);
}

TEST(Proxied, AConnectionGoesOnAfterItsHeaderInPiecesAndAMalformedOneIsRefused) {
  TestServer server(behind_a_proxy(true));
  RawClient client(server.port());
  for (const char c : std::string("PROXY UNKNOWN\r\n")) client.send(std::string(1, c));
  for (int k = 0; k < 2; ++k) {
    client.send(post_of(kBody, ""));
    EXPECT_EQ(client.receive()->status, 200);
  }
  RawClient plain(server.port());
  plain.send(post_of(kBody, ""));
  EXPECT_EQ(plain.receive()->status, 200) << "the header is optional";
  RawClient wrong(server.port());
  wrong.send("PROXY TCP4 nonsense\r\n");
  EXPECT_EQ(wrong.receive()->status, 400);
}

TEST(Proxied, TheConnectionsOfAProxyAreNotThoseOfOneClient) {
  TestServerOptions options = behind_a_proxy(true);
  options.limits.max_connections_per_address = 2;
  TestServer server(options);
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int k = 0; k < 5; ++k) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    clients.back()->send(post_of(kBody, ""));
    EXPECT_EQ(clients.back()->receive()->status, 200) << k;
  }
}

}  // namespace
}  // namespace fracture::test
