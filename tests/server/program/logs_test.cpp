// The log of the real program, line by line.
#include <gtest/gtest.h>

#include <fcntl.h>

#include <thread>

#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/requests.hpp"
#include "tests/server/support/server_process.hpp"

namespace fracture::test {
namespace {

using nlohmann::json;

/// Stops the server and parses the lines that it has logged since it began to listen. Every line must be a
/// JSON object.
std::vector<json> log_of(ServeProcess& server) {
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
  std::vector<json> lines;
  for (std::string line = server.error_line(); !line.empty(); line = server.error_line()) {
    lines.push_back(json::parse(line, nullptr, false));
    EXPECT_TRUE(lines.back().is_object()) << line;
  }
  return lines;
}

std::vector<json> requests(const std::vector<json>& lines) {
  std::vector<json> found;
  for (const json& line : lines)
    if (line.value("event", "") == "request") found.push_back(line);
  return found;
}

TEST(Logs, EveryRequestIsOneJsonLineWithItsFigures) {
  ServeProcess server;
  const std::string trace = "4bf92f3577b34da6a3ce929d0e0e4736", parent = "00f067aa0ba902b7";
  const Reply made = ask(server.port, "POST", "/fracture?sites=4",
                         "Content-Type: model/obj\r\nX-Request-Id: shot-12\r\ntraceparent: 00-" + trace +
                             "-" + parent + "-01\r\n",
                         kCube);
  ASSERT_EQ(made.status, 200);
  ask(server.port, "GET", "/a%0Ab%22c?x=1", "X-Request-Id: bad id\r\ntraceparent: 00-xyz\r\n");
  RawClient broken(server.port);
  broken.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(broken.receive()->status, 400);
  ask(server.admin_port, "GET", "/livez");

  const std::vector<json> lines = requests(log_of(server));
  ASSERT_EQ(lines.size(), 3u) << "probes are not logged at level info";
  EXPECT_EQ(lines[0].at("id"), "shot-12");
  EXPECT_EQ(lines[0].at("method"), "POST");
  EXPECT_EQ(lines[0].at("route"), "/fracture");
  EXPECT_EQ(lines[0].at("status"), 200);
  EXPECT_EQ(lines[0].at("in"), kCube.size());
  EXPECT_EQ(lines[0].at("out"), made.body.size());
  EXPECT_GT(lines[0].at("ms").get<double>(), 0);
  EXPECT_GE(lines[0].at("queue_ms").get<double>(), 0);
  EXPECT_EQ(lines[0].at("cache"), made.header("cache-status"));
  EXPECT_EQ(lines[0].at("mesh"), made.header("etag").substr(1, 16));
  EXPECT_EQ(lines[0].at("trace_id"), trace);
  EXPECT_EQ(lines[0].at("parent_id"), parent);
  EXPECT_EQ(lines[0].at("address"), "127.0.0.1");
  EXPECT_FALSE(lines[0].contains("delivered"));
  EXPECT_EQ(lines[1].at("status"), 404);
  EXPECT_EQ(lines[1].at("path"), "/a?b\"c");
  EXPECT_EQ(lines[1].at("route"), "");
  EXPECT_NE(lines[1].at("id"), "bad id");
  EXPECT_FALSE(lines[1].contains("trace_id"));
  EXPECT_EQ(lines[2].at("status"), 400);
}

// A header of 16 KiB must not make a log line of 16 KiB: client text is cut in every part of the request.
TEST(Logs, NoRequestMakesALongLine) {
  ServeProcess server;
  const std::string far(3'000, 'x'), far_method(15'000, 'X');
  ask(server.port, far_method, "/version");
  ask(server.port, "GET", "/" + far,
      "X-Request-Id: " + far + "\r\ntraceparent: " + far + "\r\nForwarded: for=" + far + "\r\n");
  ask(server.port, "GET", "/version", "Host: " + far + "\r\n");
  ask(server.port, "POST", "/fracture?" + far + "=1", kObj + "Prefer: " + far + "\r\nOrigin: " + far + "\r\n",
      kCube);
  const std::vector<json> lines = requests(log_of(server));
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0].at("method"), far_method.substr(0, 16));
  EXPECT_EQ(lines[0].at("status"), 501);
  EXPECT_EQ(lines[1].at("path"), "/" + far.substr(0, 199));
  for (const json& line : lines) EXPECT_LT(line.dump().size(), 600u) << line.dump();
}

TEST(Logs, TheStartIsLoggedWithEverySetting) {
  Process server({"serve", "--port", "0", "--admin-port", "0", "--max-uri", "2KiB", "--drain-delay", "0"});
  const json start = json::parse(server.error_line_with("\"configuration\""), nullptr, false);
  ASSERT_TRUE(start.is_object());
  EXPECT_EQ(start.at("max-uri"), 2048);
  EXPECT_EQ(start.at("max-body"), 64 << 20);
  EXPECT_EQ(start.at("insecure-bind"), false);
  EXPECT_FALSE(server.error_line_with("serving on").empty());
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST(Logs, ALogThatNobodyReadsStopsNeitherTheServerNorItsEnd) {
  ServeProcess server;  // Its standard error is a pipe of 64 KiB that no process empties from here on.
  for (int i = 0; i < 1000; ++i)
    ASSERT_EQ(ask(server.port, "GET", "/version", "X-Request-Id: " + std::string(64, 'x') + "\r\n").status,
              200);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST(Logs, TextIsForPeople) {
  ServeProcess server({"--log-format", "text"});
  ask(server.port, "GET", "/version", "X-Request-Id: one\r\n");
  const std::string line = server.error_line_with("request ");
  EXPECT_NE(line.find("id=one method=GET path=/version route=/version status=200"), std::string::npos)
      << line;
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST(Logs, AWrongConfigurationEndsWithTwoAndNamesEveryMistake) {
  Process server({"serve", "--port", "99999", "--idle", "soon", "--address", "0.0.0.0"});
  std::string all;
  for (std::string line = server.error_line(); !line.empty(); line = server.error_line()) all += line;
  EXPECT_EQ(server.wait(), 2);
  for (const char* name : {"port must be", "idle must be", "--insecure-bind"})
    EXPECT_NE(all.find(name), std::string::npos) << all;
}

}  // namespace
}  // namespace fracture::test
