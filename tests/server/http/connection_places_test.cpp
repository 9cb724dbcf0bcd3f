// Clients share the places for connections: a client without a connection finds a place, and a refused client
// holds none.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "server/http/connections.hpp"
#include "tests/server/support/gate.hpp"
#include "tests/server/support/job_server.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

TEST(ConnectionPlaces, OneAddressCannotTakeAllConnections) {
  TestServerOptions options;
  options.limits.max_connections_per_address = 3;
  TestServer server(options);
  std::vector<std::unique_ptr<RawClient>> open;
  for (int i = 0; i < 3; ++i) {
    open.push_back(std::make_unique<RawClient>(server.port()));
    open.back()->send("GET /version HTTP/1.1\r\nHost: a\r\n\r\n");
    EXPECT_EQ(open.back()->receive()->status, 200);
  }
  RawClient fourth(server.port());
  const auto reply = fourth.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->problem(), "too-many-connections");
  EXPECT_EQ(reply->header("retry-after"), "2");
  open.clear();
  EXPECT_TRUE(eventually(kPatience, "all connections to close", [&] {
    fourth.half_close();
    return server.server.connections() == 0;
  }));
  EXPECT_EQ(server.get("/version").status, 200);
}

TEST(ConnectionPlaces, AServerWithAllConnectionsTakenSaysSo) {
  TestServerOptions options;
  options.limits.max_connections = 2;
  TestServer server(options);
  Gate gate;
  server.control->during_cut = gate.hook();
  RawClient a(server.port()), b(server.port());
  int seed = 0;
  for (RawClient* client : {&a, &b})
    client->send("POST /fracture?seed=" + std::to_string(seed++) +
                 " HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n\r\nmesh");
  gate.wait_for(2);
  RawClient c(server.port());
  const auto reply = c.receive();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->problem(), "overloaded");
  EXPECT_EQ(reply->header("retry-after"), "2");
  RawClient other(server.port(), "127.0.0.2");
  other.send("GET /version HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_EQ(other.receive()->status, 200) << "who has none takes the place of one of two";
  const auto given_up = b.receive();
  ASSERT_TRUE(given_up) << "which is told so";
  EXPECT_EQ(given_up->status, 503);
  gate.open = true;
  EXPECT_EQ(a.receive()->status, 200);
}

TEST(ConnectionPlaces, ConnectionsThatOnlyWaitGiveWay) {
  TestServerOptions options;
  options.limits.max_connections = 4;
  options.limits.idle = options.limits.header_timeout = options.limits.body_grace = std::chrono::seconds(60);
  TestServer server(options);
  const std::string head =
      "POST /fracture HTTP/1.1\r\nHost: a\r\nContent-Type: model/obj\r\nContent-Length: 9\r\n\r\n";
  std::vector<std::unique_ptr<RawClient>> waiting;
  for (const std::string& sent : {std::string(), std::string("GET /version HT"), head, head + "mesh"}) {
    waiting.push_back(std::make_unique<RawClient>(server.port(), "127.0.0.2"));
    waiting.back()->send(sent);
  }
  EXPECT_TRUE(eventually(kPatience, "all to be there", [&] { return server.server.connections() == 4; }));
  for (int k = 0; k < 20; ++k)
    EXPECT_EQ(ask(server.port(), "GET", "/version", "", "", "127.0.0.3").status, 200) << k;
}

/// A connection lingers for as long as it sends a byte now and then. All lingering connections of one address
/// together must not take places from others.
TEST(ConnectionPlaces, RefusedConnectionsOfOneAddressHoldUpNobody) {
  TestServerOptions options;
  options.limits.max_connections = 8;
  options.limits.max_connections_per_address = 4;
  TestServer server(options);
  std::vector<std::unique_ptr<RawClient>> many;
  for (int k = 0; k < 200; ++k) {
    many.push_back(std::make_unique<RawClient>(server.port(), "127.0.0.2"));
    many.back()->send("x");
    if (k % 10 == 9) {
      EXPECT_EQ(ask(server.port(), "GET", "/version", "", "", "127.0.0.3").status, 200) << k;
    }
  }
  EXPECT_TRUE(eventually(kPatience, "all to be taken or closed", [&] {
    return server.server.connections() <= 4 + http::Connections::kMostToldOfClient;
  }));
  for (int k = 0; k < 20; ++k)
    EXPECT_EQ(ask(server.port(), "GET", "/version", "", "", "127.0.0.3").status, 200) << k;
}

/// A stream of events may last as long as its job. It counts as a waiting connection, so many streams cannot
/// keep others out.
TEST(ConnectionPlaces, StreamsOfEventsGiveWay) {
  TestServerOptions options;
  options.limits.max_connections = 4;
  TestServer server(options);
  Gate gate;
  server.control->during_cut = gate.hook();
  const std::string job = server.post("/fracture", "mesh", kAsync).header("location");
  wait_for_state(server, job, "running");
  std::vector<std::unique_ptr<RawClient>> streams;
  for (int k = 0; k < 4; ++k) {
    streams.push_back(std::make_unique<RawClient>(server.port(), "127.0.1." + std::to_string(k + 1)));
    streams.back()->send("GET " + job + "/events HTTP/1.1\r\nHost: a\r\n\r\n");
    ASSERT_TRUE(streams.back()->receive_until("event: progress"));
  }
  for (int k = 0; k < 5; ++k)
    EXPECT_EQ(ask(server.port(), "GET", "/version", "", "", "127.0.0." + std::to_string(k + 2)).status, 200)
        << k;
  gate.open = true;
}

/// This also holds for a client behind a proxy that reports its address.
TEST(ConnectionPlaces, AClientBehindAProxyHasNoMoreThanOthers) {
  TestServerOptions options;
  options.limits.max_connections_per_address = 2;
  options.server.proxies.add("127.0.0.1");
  TestServer server(options);
  Gate gate;
  server.control->during_cut = gate.hook();
  const auto ask_for = [&](RawClient& proxy, const std::string& client, int seed) {
    proxy.send("POST /fracture?seed=" + std::to_string(seed) + " HTTP/1.1\r\nHost: a\r\nForwarded: for=" +
               client + "\r\nContent-Type: model/obj\r\nContent-Length: 4\r\n\r\nmesh");
  };
  RawClient a(server.port()), b(server.port()), c(server.port()), d(server.port());
  ask_for(a, "198.51.100.1", 1);
  ask_for(b, "198.51.100.1", 2);
  gate.wait_for(2);
  ask_for(c, "198.51.100.1", 3);
  EXPECT_EQ(c.receive()->problem(), "too-many-connections");
  gate.open = true;
  ask_for(d, "198.51.100.2", 4);
  EXPECT_EQ(d.receive()->status, 200);
  EXPECT_EQ(a.receive()->status, 200);
  EXPECT_EQ(b.receive()->status, 200);
  ask_for(d, "198.51.100.1", 5);
  EXPECT_EQ(d.receive()->status, 200) << "its connections are the proxy's again";
}

}  // namespace
}  // namespace fracture::test
