// Everyday faults and commands under load: a damaged cache file, signals, long jobs.
#include <signal.h>

#include <map>
#include <optional>

#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

TEST(OperationsAttack, CacheFileOfFourTebibytes) {
  const TemporaryFolder folder;
  Siege siege({"--cache-dir", folder / "cache", "--result-cache", "0"});
  const auto post = [&] { return ask(siege.server.port, "POST", "/fracture?sites=9&seed=77", kObj, kCube); };
  const Reply made = post();
  ASSERT_EQ(made.status, 200);
  const std::string key = made.header("content-location").substr(std::string("/fractures/sha256:").size());
  const auto entry = [&]() -> std::optional<std::filesystem::path> {
    for (const auto& file : entries_in(folder / "cache"))
      if (file.filename().string().find(key) != std::string::npos) return file;
    return std::nullopt;
  };
  ASSERT_TRUE(eventually(kPatience, "the answer on the disk", [&] { return entry().has_value(); })) << key;
  int same = 0, missing = 0;
  constexpr int kTimes = 3;
  for (int k = 0; k < kTimes; ++k) {
    std::filesystem::resize_file(*entry(), std::uintmax_t{4} << 40);
    try {
      missing += ask(siege.server.port, "GET", made.header("content-location")).status == 404;
      same += post().body == made.body;
    } catch (const std::runtime_error& e) {
      ADD_FAILURE() << e.what();
      break;
    }
    ASSERT_TRUE(eventually(kPatience, "it to be written again", [&] {
      const auto file = entry();
      return file && std::filesystem::file_size(*file) < 10u << 20;
    }));
  }
  EXPECT_EQ(missing, kTimes);
  EXPECT_EQ(same, kTimes);
  siege.judge("CacheFileOfFourTebibytes", "std::terminate; the same request kills the server again",
              Siege::Refusals::kNone, "computed again " + std::to_string(same) + " times, the same bytes");
}

TEST(OperationsAttack, Hangup) {
  Siege siege;
  constexpr int kTimes = 20;
  for (int k = 0; k < kTimes && siege.server.alive(); ++k) {
    const int until = siege.neighbours->served + 1;
    siege.server.signal(SIGHUP);
    EXPECT_TRUE(eventually(kPatience, "the next answer", [&] {
      return siege.neighbours->served >= until || siege.neighbours->failed != 0;
    }));
  }
  siege.judge("Hangup", "ends the process without a drain", Siege::Refusals::kNone,
              std::to_string(kTimes) + " signals");
}

// A system that is short of memory kills importers first. A client that posts meanwhile may be told so, but
// must not be told of a bug.
TEST(OperationsAttack, KilledImporters) {
  Siege siege;
  std::map<int, int> statuses;
  const int times = full_tests() ? 200 : 40;
  for (int k = 0; k < times; ++k) {
    for (const std::string& child : children_of(std::to_string(siege.server.pid())))
      ::kill(std::stoi(child), SIGKILL);
    const std::string mesh = kCube + "# " + std::to_string(k) + "\n";
    try {
      ++statuses[ask(siege.server.port, "POST", "/fracture?sites=4", kObj, mesh).status];
    } catch (const std::runtime_error&) {
      ++statuses[0];
    }
  }
  EXPECT_EQ(statuses[500], 0);
  EXPECT_EQ(statuses[0], 0);
  EXPECT_EQ(ask(siege.server.port, "POST", "/fracture?sites=4", kObj, kCube + "#\n").status, 200);
  siege.judge(
      "KilledImporters", "of 40 requests beside killed importers 9 were answered 500", Siege::Refusals::kNone,
      "posts beside them: " + std::to_string(statuses[200]) + " served, " + std::to_string(statuses[422]) +
          " times 422, " + std::to_string(statuses[500]) + " times 500");
}

std::string state_of(const ServeProcess& server, const std::string& job) {
  return ask(server.port, "GET", job).json().value("state", "");
}

// A job has its own time limit, whatever a request may take: it ends well after the deadlines of both classes
// have passed.
TEST(OperationsAttack, LongJobs) {
  Siege siege({"--memory", "4GiB", "--deadline", "0.2", "--realtime-deadline", "0.2"});
  siege.neighbours->stop();  // these deadlines apply to them as well
  const int failed_before = siege.neighbours->failed;
  const Reply stored = ask(siege.server.port, "POST", "/meshes", kObj, kCube);
  const std::string id = stored.json().value("id", "");
  const int sites = full_tests() ? 25'000 : 15'000;
  const std::string body = R"({"sites": )" + std::to_string(sites) + "}";
  const auto job = [&](const std::string& target, const std::string& fields, const std::string& text) {
    const Reply reply = ask(siege.server.port, "POST", target, fields + kRespondAsync, text);
    EXPECT_EQ(reply.status, 202) << reply.body;
    return reply.header("location");
  };
  const std::string of_stored = job("/meshes/" + id + "/fracture", kJson, body),
                    of_body = job("/fracture?seed=2&sites=" + std::to_string(sites), kObj, kCube);
  std::string states;
  for (const std::string& each : {of_stored, of_body}) {
    std::string state;
    EXPECT_TRUE(eventually(kPatience, "the job to end", [&] {
      state = state_of(siege.server, each);
      return state != "queued" && state != "running";
    }));
    EXPECT_EQ(state, "done") << ask(siege.server.port, "GET", each).body;
    states += (states.empty() ? "" : ", ") + state;
  }
  EXPECT_EQ(failed_before, 0);
  siege.neighbours = std::make_unique<Neighbours>(siege.server);
  siege.neighbours->stop();
  siege.judge("LongJobs", "inherits 2 s of realtime and fails; other jobs end at 60 s",
              Siege::Refusals::kAllowed, "deadlines of 0.2 s, jobs: " + states);
}

// A job that runs when the server is told to stop is finished within the grace period. The next server has
// its result.
TEST(OperationsAttack, DrainWithAJob) {
  const TemporaryFolder folder;
  const std::vector<std::string> settings = {"--memory", "4GiB",        "--grace",
                                             "120",      "--cache-dir", folder / "cache"};
  std::string job;
  {
    ServeProcess server(settings);
    const Reply started = ask(server.port, "POST", "/fracture?sites=15000", kObj + kRespondAsync, kCube);
    ASSERT_EQ(started.status, 202) << started.body;
    job = started.header("location");
    EXPECT_TRUE(eventually(kPatience, "it to run", [&] { return state_of(server, job) != "queued"; }));
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait(), 0);
  }
  ServeProcess server(settings);
  const std::string state = state_of(server, job);
  EXPECT_EQ(state, "done") << ask(server.port, "GET", job).body;
  report("DrainWithAJob", state == "done" ? "finished within the grace, known to the next server" : "lost",
         "a drain cancels jobs at once");
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

}  // namespace
}  // namespace fracture::test
