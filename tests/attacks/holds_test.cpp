// The resources that refused and queued requests hold, and that jobs leave behind: however many clients hold
// a little, the last of it is never taken from others.
#include <array>
#include <deque>

#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/tenant_file.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

double connections(const ServeProcess& server) {
  return parse_exposition(ask(server.admin_port, "GET", "/metrics").body)["fracture_connections"];
}

TEST(HoldsAttack, RefusedConnectionsThatDrip) {
  Siege siege({"--max-connections", "80"});
  constexpr int kAttackers = 3;
  constexpr std::size_t kKept = 150;
  std::array<std::deque<std::unique_ptr<RawClient>>, kAttackers> kept;
  siege.attack(kAttackers, full_tests() ? 4000 : 600, [&](const std::string& from, int n) {
    auto& mine = kept[static_cast<std::size_t>(n % kAttackers)];
    mine.push_back(std::make_unique<RawClient>(siege.server.port, from));
    mine.back()->send("x");
    if (mine.size() > kKept) mine.pop_front();
    mine[static_cast<std::size_t>(n / kAttackers) % mine.size()]->send("x");
    return 0;
  });
  siege.statuses.clear();
  EXPECT_LE(connections(siege.server), 80 + 64) << "places, and a few beyond them";
  siege.judge("RefusedConnectionsThatDrip", "79 a second of one address: 503 for everybody",
              Siege::Refusals::kNone);
}

TEST(HoldsAttack, ConnectionsOfManyAddresses) {
  Siege siege({"--max-connections", "100", "--idle", "60", "--header-timeout", "60", "--body-grace", "60"});
  std::vector<std::unique_ptr<RawClient>> many;
  for (int k = 0; k < 300; ++k) {
    many.push_back(std::make_unique<RawClient>(siege.server.port, "127.0.2." + std::to_string(k % 250 + 1)));
    if (k % 3 == 1) many.back()->send("GET /version HT");
    if (k % 3 == 2) many.back()->send(kPostObj + "Content-Length: 10000\r\n\r\n#");
  }
  const int end = siege.neighbours->probes + 40;
  EXPECT_TRUE(eventually(kPatience, "the neighbours",
                         [&] { return siege.neighbours->probes >= end || siege.neighbours->failed > 0; }));
  many.clear();  // otherwise the server waits for the rest of their requests when it stops
  siege.judge("ConnectionsOfManyAddresses", "100 addresses that wait: 503 for everybody",
              Siege::Refusals::kNone);
}

/// Submits jobs from each address until one is refused, at most `most` of them. Returns how many were
/// accepted.
int fill_the_queue(const ServeProcess& server, int addresses, int most) {
  int taken = 0;
  for (int k = 0; k < addresses; ++k) {
    const std::string from = "127.0.3." + std::to_string(k + 1);
    for (int job = 0; job < most; ++job) {
      const std::string target =
          "/fracture?sites=" + std::to_string(200 + k) + "&lloyd=50&seed=" + std::to_string(job);
      if (ask(server.port, "POST", target, kObj + kRespondAsync, kCube, from).status != 202) break;
      ++taken;
    }
  }
  return taken;
}

TEST(HoldsAttack, QueuedJobs) {
  struct Case {
    const char* name;
    int addresses, most;
  };
  for (const Case& c : {Case{"QueuedJobsOfTwo", 2, 400}, Case{"QueuedJobsOfMany", 120, 4}}) {
    Siege siege({"--threads", "1", "--memory", "2GiB", "--job-ttl", "5"});
    // The only computing thread is busy for long, so all others wait.
    ASSERT_EQ(ask(siege.server.port, "POST", "/fracture?sites=8000&lloyd=50", kObj + kRespondAsync, kCube,
                  "127.0.3.1")
                  .status,
              202);
    const int taken = fill_the_queue(siege.server, c.addresses, c.most);
    EXPECT_GE(taken, 300) << c.name;
    const int end = siege.neighbours->served + (full_tests() ? 10 : 2) * kServed;
    EXPECT_TRUE(eventually(kPatience, "the neighbours", [&] {
      return siege.neighbours->served >= end || siege.neighbours->refused > 0 || siege.neighbours->failed > 0;
    }));
    EXPECT_EQ(ask(siege.server.port, "POST", "/fracture?sites=10", kObj + kRespondAsync, kCube, "127.0.0.99")
                  .status,
              202)
        << "a job of somebody else";
    siege.judge(c.name, "253 jobs hold all working memory: 0 of 453 computations of a third were answered",
                Siege::Refusals::kNone, std::to_string(taken) + " jobs taken");
  }
}

TEST(HoldsAttack, JobsWhoseAnswerIsKnown) {
  const TemporaryFolder folder;
  folder.write("tokens", tenant_file({tenant("quiet"), tenant("greedy", {"read", "fracture", "bake"},
                                                              {{"computations", 1}, {"weight", 0.01}})}));
  ServeProcess server({"--memory", "2GiB", "--token-file", folder / "tokens", "--cache-dir", folder / "cache",
                       "--max-jobs", full_tests() ? "1000" : "100"});
  const auto start = [&](const std::string& name, int seed) {
    return ask(server.port, "POST", "/fracture?sites=5&seed=" + std::to_string(seed),
               kObj + kRespondAsync + by(name), kCube);
  };
  const auto look = [&](const std::string& job) { return ask(server.port, "GET", job, by("quiet")); };
  std::vector<std::string> mine;
  for (int seed = 0; seed < 5; ++seed) {
    mine.push_back(start("quiet", seed).header("location"));
    ASSERT_TRUE(eventually(kPatience, "a job to be done", [&] {
      const Reply reply = look(mine.back());
      return reply.status == 200 && reply.json().value("state", "") == "done" &&
             reply.json().value("durable", false);
    }));
  }
  const int flood = full_tests() ? 1000 : 100;
  int taken = 0;
  EXPECT_TRUE(eventually(kPatience, "the flood", [&] {
    taken += start("greedy", 77).status == 202;
    return taken >= flood;
  }));
  int there = 0;
  for (const std::string& job : mine) there += look(job).status == 200;
  EXPECT_EQ(there, 5);
  report("JobsWhoseAnswerIsKnown",
         std::to_string(taken) + " of them; of 5 finished jobs of another name " + std::to_string(there) +
             " are left",
         "1000 of them: all finished jobs of others were forgotten, on the disk too");
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

}  // namespace
}  // namespace fracture::test
