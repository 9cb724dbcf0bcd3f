// SIGHUP reads the token file again; a wrong file changes nothing. Also tests the audit lines.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/tenant_file.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

TEST(Reload, ANewTokenFileDecidesAndAWrongOneIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "tokens";
  write(path, tenant_file({tenant("ana"), tenant("bob")}));
  ServeProcess server({"--token-file", path, "--log-format", "json"});
  EXPECT_EQ(ask(server.port, "GET", "/version", by("ana")).status, 200);
  EXPECT_EQ(ask(server.port, "GET", "/version", by("cyd")).status, 401);

  write(path, tenant_file({tenant("ana"), tenant("cyd")}));
  server.signal(SIGHUP);
  EXPECT_NE(server.error_line_with("was reloaded"), "");
  EXPECT_EQ(ask(server.port, "GET", "/version", by("bob")).status, 401);
  EXPECT_EQ(ask(server.port, "GET", "/version", by("cyd")).status, 200);

  write(path, "{\"tenants\": [{\"name\": \"ana\"}]}");
  server.signal(SIGHUP);
  const std::string line = server.error_line_with("stay in force");
  EXPECT_NE(line.find("tenants[0].tokens"), std::string::npos) << line;
  EXPECT_NE(line.find("\"level\":\"error\""), std::string::npos) << line;
  EXPECT_EQ(ask(server.port, "GET", "/version", by("ana")).status, 200);
  EXPECT_EQ(ask(server.port, "GET", "/version", by("cyd")).status, 200);
  ASSERT_TRUE(server.alive());
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST(Reload, WhatIsNoFileIsRefusedAndNobodyWaitsForIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "tokens";
  write(path, tenant_file({tenant("ana")}));
  ServeProcess server({"--token-file", path, "--log-format", "json"});
  std::filesystem::remove(path);
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  server.signal(SIGHUP);
  // Ends the test if the server waits for a writer of the pipe.
  std::atomic<bool> done{false};
  std::thread watch([&] {
    if (!eventually(std::chrono::seconds(60), "the refusal", [&] { return done.load(); }))
      server.signal(SIGKILL);
  });
  EXPECT_NE(server.error_line_with("not a regular file"), "");
  done = true;
  watch.join();
  EXPECT_EQ(ask(server.port, "GET", "/version", by("ana")).status, 200);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST(Reload, WithoutATokenFileTheSignalChangesNothing) {
  ServeProcess server;
  server.signal(SIGHUP);
  EXPECT_NE(server.error_line_with("no token file"), "");
  EXPECT_EQ(ask(server.port, "GET", "/version").status, 200);
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

TEST(Audit, EveryWriteUnderATokenHasALineAndReadsHaveNone) {
  const TemporaryFolder folder;
  const std::string path = folder / "tokens";
  write(path, tenant_file({tenant("ana")}));
  ServeProcess server({"--token-file", path, "--log-format", "json"});
  const std::string id = "sha256:" + std::string(64, 'a');
  ask(server.port, "GET", "/version", by("ana"));
  ask(server.port, "DELETE", "/meshes/" + id, by("ana"));
  const auto line =
      nlohmann::json::parse(server.error_line_with("\"audit\""), nullptr, /*allow_exceptions=*/false);
  ASSERT_TRUE(line.is_object());
  EXPECT_EQ(line.at("client"), "ana");
  EXPECT_EQ(line.at("method"), "DELETE");
  EXPECT_EQ(line.at("path"), "/meshes/" + id);
  EXPECT_EQ(line.at("status"), 404);
  EXPECT_EQ(line.at("address"), "127.0.0.1");
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

}  // namespace
}  // namespace fracture::test
