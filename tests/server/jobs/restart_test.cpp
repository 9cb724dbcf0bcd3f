// A real server is killed with SIGKILL in every state of a job. Each accepted job is found again under its id
// and finishes.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// A sphere of 2 * rings * rings triangles. Its bumps avoid coordinates that are round by accident.
std::string sphere(int rings) {
  std::string obj;
  char line[128];
  const auto add = [&](double theta, double phi) {
    const double r = 1 + 0.1 * std::sin(5 * theta) * std::cos(3 * phi);
    std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", r * std::sin(theta) * std::cos(phi),
                  r * std::sin(theta) * std::sin(phi), r * std::cos(theta));
    obj += line;
  };
  const double pi = std::acos(-1.0);
  add(0, 0);
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < rings; ++j) add(pi * i / rings, 2 * pi * j / rings);
  add(pi, 0);
  const auto at = [&](int i, int j) { return 2 + (i - 1) * rings + j % rings; };
  const auto face = [&](int a, int b, int c) {
    std::snprintf(line, sizeof line, "f %d %d %d\n", a, b, c);
    obj += line;
  };
  const int last = 2 + (rings - 1) * rings;
  for (int j = 0; j < rings; ++j) {
    face(1, at(1, j), at(1, j + 1));
    face(last, at(rings - 1, j + 1), at(rings - 1, j));
    for (int i = 1; i < rings - 1; ++i) {
      face(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      face(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return obj;
}

struct Restart : testing::Test {
  TemporaryFolder folder;
  std::optional<ServeProcess> server;
  /// Small enough (kReadInline) that a 202 never waits for a thread of the pool.
  const std::string mesh = sphere(55);

  void start() {
    server.reset();
    server.emplace(std::vector<std::string>{"--cache-dir", folder.path});
  }
  void kill() {
    server->signal(SIGKILL);
    EXPECT_EQ(server->wait(), 1000 + SIGKILL);
  }
  std::string submit(const std::string& query) {
    const Reply reply = ask(server->port, "POST", "/fracture?" + query,
                            "Content-Type: model/obj\r\nPrefer: respond-async\r\n", mesh);
    EXPECT_EQ(reply.status, 202) << reply.body;
    EXPECT_EQ(reply.json().value("durable", false), true) << reply.body;
    return reply.header("location");
  }
  nlohmann::json get(const std::string& job) { return ask(server->port, "GET", job).json(); }
  nlohmann::json wait_for(const std::string& job, const std::string& state) {
    nlohmann::json document;
    EXPECT_TRUE(eventually(3 * kPatience, job + " to be " + state, [&] {
      document = get(job);
      return document.is_object() && document.value("state", "") == state;
    })) << document.dump();
    return document;
  }
  std::string result_of(const std::string& job) {
    const Reply reply = ask(server->port, "GET", wait_for(job, "done").value("result", "/"));
    EXPECT_EQ(reply.status, 200);
    return reply.body;
  }
};

TEST_F(Restart, WhateverItsStateAJobIsThereAfterAKillAndFinishes) {
  start();
  const std::string small = submit("sites=20");
  const std::string answer = result_of(small);
  std::vector<std::string> jobs;
  for (const char* query : {"sites=2000&lloyd=50&seed=1", "sites=2000&lloyd=50&seed=2",
                            "sites=2000&lloyd=50&seed=6", "sites=40&seed=3"})
    jobs.push_back(submit(query));
  wait_for(jobs[0], "running");
  EXPECT_EQ(get(jobs[2]).value("state", ""), "queued") << "two threads compute";
  kill();

  start();
  EXPECT_EQ(result_of(small), answer) << "it was done before";
  for (const std::string& job : jobs) result_of(job);
  const std::string again =
      ask(server->port, "POST", "/fracture?sites=40&seed=3", "Content-Type: model/obj\r\n", mesh).body;
  EXPECT_EQ(result_of(jobs[3]), again) << "the bytes that the same request has at any time";
  const std::string late = submit("sites=2000&lloyd=50&seed=4");
  kill();  // at once after the 202

  start();
  result_of(late);
  for (const std::string& job : jobs) EXPECT_EQ(get(job).value("state", ""), "done");
}

TEST_F(Restart, AJobThatIsRunningAtTwoKillsHasFailedAndTheOthersHaveNot) {
  start();
  const std::string lethal = submit("sites=20000&lloyd=50");
  const std::string other = submit("sites=30");
  wait_for(other, "done");
  for (int kills = 0; kills < 2; ++kills) {
    wait_for(lethal, "running");
    kill();
    start();
  }
  const auto failed = get(lethal);
  EXPECT_EQ(failed.value("state", ""), "failed") << failed.dump();
  EXPECT_EQ(failed.at("error").value("type", ""), "/problems/job-lost");
  result_of(other);
}

TEST_F(Restart, ADrainFinishesWhatItCanAndLeavesTheRestForTheNextServer) {
  start();
  const std::string first = submit("sites=1000&lloyd=50"), second = submit("sites=30");
  wait_for(first, "running");
  server->signal(SIGTERM);
  EXPECT_EQ(server->wait(), 0);
  start();
  EXPECT_EQ(get(first).value("state", ""), "done") << "within the grace, and in the tier";
  EXPECT_EQ(get(second).value("state", ""), "done");
  result_of(first);

  server.reset();
  server.emplace(std::vector<std::string>{"--cache-dir", folder.path, "--grace", "0"});
  const std::string third = submit("sites=2000&lloyd=50&seed=5");
  wait_for(third, "running");
  server->signal(SIGTERM);
  EXPECT_EQ(server->wait(), 0);
  start();
  result_of(third);
}

}  // namespace
}  // namespace fracture::test
