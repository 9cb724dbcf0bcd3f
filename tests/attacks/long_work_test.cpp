// Long work of one client, in each class, for all processors and import workers. Others are answered
// meanwhile. The proof is a count: none of the long work has ended by the time all of their requests are
// answered.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "tests/attacks/attack.hpp"
#include "tests/attacks/bodies.hpp"
#include "tests/server/support/exposition.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/server/support/tenant_file.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

const std::string kAttacker = "127.0.1.1", kBystander = "127.0.1.2";
constexpr int kQuestions = 10;

Exposition figures(const ServeProcess& server) {
  return parse_exposition(ask(server.admin_port, "GET", "/metrics").body);
}

/// Reports how many of the attacker's `things` ended between a question and its answer. Returns the median.
double report_median(const char* attack, const std::string& things, std::vector<double> between,
                     const char* before) {
  std::sort(between.begin(), between.end());
  const double median = between[between.size() / 2];
  char number[20];
  std::snprintf(number, sizeof number, "%.0f ", median);
  report(attack, number + things + " of the other between question and answer, median", before);
  return median;
}

/// Requests that take long, each on its own connection. The destructor resets the
/// connections.
class LongWork {
 public:
  LongWork(const ServeProcess& server, int count, const std::string& target, const std::string& fields,
           const std::string& body = kCube) {
    for (int k = 0; k < count; ++k) {
      const std::string mesh = body + "# " + std::to_string(k) + "\n";  // a different mesh for each
      clients_.push_back(std::make_unique<RawClient>(server.port, kAttacker));
      clients_.back()->send("POST " + target + " HTTP/1.1\r\nHost: localhost\r\n" + kObj + fields +
                            "Content-Length: " + std::to_string(mesh.size()) + "\r\n\r\n" + mesh);
    }
  }
  ~LongWork() {
    for (const auto& client : clients_) client->reset();
  }

 private:
  std::vector<std::unique_ptr<RawClient>> clients_;
};

struct LongWorkAttack : testing::TestWithParam<std::string> {
  ServeProcess server{
      {"--threads", "2", "--import-workers", "2", "--memory", "4GiB", "--realtime-deadline", "60"}};

  /// Sends the bystander's requests. Returns how many were answered, and expects that at most `others` other requests were.
  int answered(const std::string& fields, int others = 0) {
    int good = 0;
    const double before = figures(server)["fracture_results_computed_total"];
    for (int k = 0; k < kQuestions; ++k) {
      const std::string mesh = kCube + "# bystander " + std::to_string(++seed_) + "\n";
      const Reply reply = ask(server.port, "POST", "/fracture?sites=8", kObj + fields, mesh, kBystander);
      good += reply.status == 200;
    }
    EXPECT_LE(figures(server)["fracture_results_computed_total"] - before, good + others);
    return good;
  }
  void end(const std::string& attack, int good, const std::string& before) {
    report(attack,
           std::to_string(good) + " of " + std::to_string(kQuestions) +
               " answers to another client before one of the long ones",
           before);
    ASSERT_TRUE(server.alive());
    server.signal(SIGTERM);
    EXPECT_EQ(server.wait(), 0);
  }

 private:
  int seed_ = 0;
};

const std::string kU0 = "Priority: u=0\r\n", kU3 = "Priority: u=3\r\n";

TEST_P(LongWorkAttack, Computations) {
  int good = 0;
  {
    const LongWork work(server, 4, "/fracture?sites=12000&lloyd=50", GetParam());
    EXPECT_TRUE(eventually(kPatience, "both processors to be taken",
                           [&] { return figures(server).sum("fracture_jobs_running") >= 2; }));
    good = answered(kU3);
    EXPECT_EQ(good, kQuestions);
    EXPECT_EQ(answered(kU0), kQuestions);
  }
  end("LongComputations", good, "a batch request waits for the end of one: 28 s");
}

TEST_P(LongWorkAttack, Imports) {
  int good = 0;
  {
    const LongWork work(server, 12, "/fracture?sites=8", GetParam(), kCube + many("o o\nf 1 2 3\n", 400'000));
    EXPECT_TRUE(eventually(kPatience, "both import workers to be taken",
                           [&] { return figures(server).sum("fracture_import_workers_busy") >= 2; }));
    good = answered(kU3, 11);  // at least the last import is not done
    EXPECT_EQ(good, kQuestions);
  }
  end("LongImports", good, "an upload waits for the end of one: a minute");
}

INSTANTIATE_TEST_SUITE_P(Classes, LongWorkAttack, testing::Values(kU0, kU3),
                         [](const auto& instance) { return instance.param == kU0 ? "Realtime" : "Batch"; });

/// Sixteen connections of one client, each with one file after the other that is refused after it was read.
class ImportFlood {
 public:
  ImportFlood(const ServeProcess& server, const std::string& fields) {
    for (int client = 0; client < 16; ++client)
      threads_.emplace_back([this, client, port = server.port, fields] {
        const std::string faces = kCube + many("o o\nf 1 2 3\n", 5000);
        for (int n = 0; !stop_; ++n) {
          try {
            ask(port, "POST", "/fracture?sites=8", kObj + fields,
                faces + "# " + std::to_string(client) + " " + std::to_string(n) + "\nf 1 2 99\n", kAttacker);
          } catch (const std::runtime_error&) {
            // cut off at the end
          }
        }
      });
  }
  ~ImportFlood() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

struct ImportFloodAttack : testing::TestWithParam<std::string> {};

/// Counts how many imports of the flood end between another client's request and its answer.
TEST_P(ImportFloodAttack, WaitsForAnotherClientHoweverManyAreInLine) {
  ServeProcess server(
      {"--threads", "16", "--import-workers", "2", "--memory", "4GiB", "--realtime-deadline", "60"});
  const auto refused = [&] { return figures(server)["fracture_imports_total{outcome=\"refused\"}"]; };
  std::vector<double> between;
  {
    const ImportFlood flood(server, GetParam());
    EXPECT_TRUE(eventually(kPatience, "a flood", [&] { return refused() >= 50; }));
    for (int k = 0; k < kQuestions; ++k) {
      const double before = refused();
      int status = 0;
      try {
        status = ask(server.port, "POST", "/fracture?sites=8", kObj + kU3,
                     kCube + "# bystander " + std::to_string(k) + "\n", kBystander)
                     .status;
      } catch (const std::runtime_error& e) {
        ADD_FAILURE() << e.what();
        break;
      }
      EXPECT_EQ(status, 200);
      between.push_back(refused() - before);
    }
  }
  ASSERT_EQ(between.size(), std::size_t{kQuestions});
  const double median = report_median("ImportFlood", "imports", between,
                                      "16, all that are in line; no answer at all if they are urgent");
  EXPECT_LE(median, 8) << "the imports that read now may end";
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

INSTANTIATE_TEST_SUITE_P(Classes, ImportFloodAttack, testing::Values(kU0, kU3),
                         [](const auto& instance) { return instance.param == kU0 ? "Realtime" : "Batch"; });

/// During a flood of small realtime requests, counts those that are answered between a batch client's request
/// and its answer.
TEST(RealtimeFlood, LeavesABatchClientItsShare) {
  ServeProcess server({"--threads", "2", "--memory", "4GiB"});
  std::atomic<bool> stop{false};
  std::vector<std::thread> flood;
  for (int client = 0; client < 16; ++client)
    flood.emplace_back([&, client] {
      for (int n = 0; !stop; ++n) {
        try {
          ask(server.port, "POST", "/fracture?sites=400&seed=" + std::to_string(10'000 * client + n),
              kObj + kU0, kCube, kAttacker);
        } catch (const std::runtime_error&) {
          // cut off at the end
        }
      }
    });
  EXPECT_TRUE(eventually(kPatience, "a flood",
                         [&] { return figures(server)["fracture_results_computed_total"] >= 50; }));
  std::vector<double> between;
  for (int k = 0; k < kQuestions; ++k) {
    const double before = figures(server)["fracture_results_computed_total"];
    EXPECT_EQ(
        ask(server.port, "POST", "/fracture?sites=8&seed=" + std::to_string(k), kObj + kU3, kCube, kBystander)
            .status,
        200);
    between.push_back(figures(server)["fracture_results_computed_total"] - before - 1);
  }
  stop = true;
  for (std::thread& thread : flood) thread.join();
  const double median = report_median("RealtimeFlood", "realtime answers", between,
                                      "a second's: batch work waits until it has aged");
  EXPECT_LE(median, 4) << "those that run end, or stand still";
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
}

/// A name with a twentieth of a processor asks for hours of processor time at once.
TEST(CoresOfAName, HoldWhileItComputes) {
  const TemporaryFolder folder;
  folder.write("tokens", tenant_file({tenant("greedy", {"read", "fracture", "bake"}, {{"cores", 0.05}}),
                                      tenant("quiet")}));
  ServeProcess server({"--threads", "2", "--memory", "4GiB", "--token-file", folder / "tokens"});
  const auto begin = std::chrono::steady_clock::now();
  int taken = 0;
  for (int k = 0; k < 10; ++k)
    taken += ask(server.port, "POST", "/fracture?sites=20000&lloyd=50&seed=" + std::to_string(k),
                 kObj + by("greedy") + "Prefer: respond-async\r\n", kCube)
                 .status == 202;
  EXPECT_GT(taken, 0);
  const auto used = [&] {
    return figures(server).sum("fracture_tenant_processor_seconds_total", "tenant=\"greedy\"");
  };
  EXPECT_TRUE(eventually(kPatience, "it to have used what it may at once", [&] { return used() >= 0.5; }));
  int good = 0;
  for (int k = 0; k < 100; ++k)
    good +=
        ask(server.port, "POST", "/fracture?sites=200&seed=" + std::to_string(k), kObj + by("quiet"), kCube)
            .status == 200;
  EXPECT_EQ(good, 100);
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(used(), 0.5 + 0.05 * time.count() + 0.5) << "what it has at once, its rate, and what polls miss";
  char text[120];
  std::snprintf(text, sizeof text, "%.2f processor seconds in %.1f s for a name with 0.05 cores", used(),
                time.count());
  report("CoresOfAName", text, "13 in 40 s");
  EXPECT_EQ(server.stop(), 0);
}

}  // namespace
}  // namespace fracture::test
