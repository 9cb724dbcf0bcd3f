// Many requests want the same compressed answer. None waits for the turn of another client.
#include "server/http/compressions.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/raw_client.hpp"
#include "tests/server/support/test_server.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

using http::Compressions;

struct CompressionsOfOneAnswer : testing::Test {
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(std::make_shared<FakeControl>())};
  WorkerPool pool{2, 256};
  Dispatcher dispatcher{service, pool};
  Compressions compressions{dispatcher};
  std::atomic<int> begun{0}, made{0}, failed{0};
  std::atomic<bool> open{false};

  void TearDown() override {
    open = true;
    dispatcher.wait_idle();
  }
  static Terms of(const std::string& client, Priority priority = Priority::kBatch) {
    Terms terms;
    terms.payer.flow = {client, 1};
    terms.priority = priority;
    return terms;
  }
  static Compressions::Made answer() { return std::make_shared<FractureResult>(); }
  /// Lets others go first, as a long computation does.
  void wait_at_polls(const Execution& execution) const {
    while (!open) {
      execution.poll();
      std::this_thread::yield();
    }
  }
  /// `make`: gets the number of the attempt, from 1. `seconds`: expected time.
  void obtain(const Terms& terms, std::function<void(int, const Execution&)> make, double seconds = 0) {
    compressions.obtain(
        {.key = "answer",
         .work = {seconds, 0},
         .terms = terms,
         .longest = kPatience,
         .make =
             [this, make = std::move(make)](const Execution& execution) {
               make(++begun, execution);
               return answer();
             },
         .reply = [this](const Expected<Compressions::Made>& reply) { ++(reply ? made : failed); }});
  }
  bool reaches(const std::atomic<int>& count, int n) {
    return eventually(kPatience, "requests to get there", [&] { return count >= n; });
  }
  std::function<void(int, const Execution&)> first_waits() {
    return [this](int attempt, const Execution& execution) {
      if (attempt == 1) wait_at_polls(execution);
    };
  }
};

// The leader of a common flight would wait behind its own computations, and everybody with it.
TEST_F(CompressionsOfOneAnswer, NobodyWaitsForTheTurnOfAnotherClient) {
  std::atomic<int> computing{0};
  for (int k = 0; k < 2; ++k)
    pool.submit(Priority::kBatch, 0,
                [&](int) {
                  ++computing;
                  while (!open) {
                    WorkerPool::turn()->give_way();
                    std::this_thread::yield();
                  }
                },
                {"greedy", 1});
  ASSERT_TRUE(reaches(computing, 2));
  for (int k = 0; k < 12; ++k) obtain(of("greedy"), [](int, const Execution&) {});
  EXPECT_EQ(pool.queued(), 12u) << "its places are taken";
  obtain(of("victim"), [](int, const Execution&) {});
  EXPECT_TRUE(reaches(made, 13)) << "although the computations go on";
  EXPECT_EQ(begun, 1);
  EXPECT_EQ(pool.queued(), 0u) << "the others left the queue";
  EXPECT_EQ(dispatcher.figures().abandoned, 0u);
}

TEST_F(CompressionsOfOneAnswer, OneAttemptIsEnoughWhileItIsInTime) {
  constexpr double kLong = 1e6;  // seconds; longer than any patience of the test
  obtain(of("first"), first_waits(), kLong);
  ASSERT_TRUE(reaches(begun, 1));
  for (const char* client : {"first", "second", "third"}) obtain(of(client), first_waits(), kLong);
  EXPECT_EQ(pool.queued(), 0u);
  open = true;
  EXPECT_TRUE(reaches(made, 4));
  EXPECT_EQ(begun, 1);
}

// Otherwise, the requests of many clients for one answer would cause refusals.
TEST_F(CompressionsOfOneAnswer, PredictionsOfTheWaitCountItOnce) {
  std::atomic<int> computing{0};
  for (int k = 0; k < 2; ++k)
    pool.submit(Priority::kRealtime, 0, [&](int) {
      ++computing;
      eventually(kPatience, "the end", [&] { return open.load(); });
    });
  ASSERT_TRUE(reaches(computing, 2));
  for (const char* client : {"first", "second", "third"}) obtain(of(client), first_waits(), 3);
  EXPECT_EQ(pool.queued(), 3u);
  EXPECT_DOUBLE_EQ(pool.backlog(Priority::kBatch).count(), 1.5) << "3 s on two processors";
  open = true;
  EXPECT_TRUE(reaches(made, 3));
}

// An attempt may stand still for as long as its client's other work takes.
TEST_F(CompressionsOfOneAnswer, AnAttemptThatTakesTooLongIsNotWaitedFor) {
  for (int k = 0; k < 3; ++k) {
    obtain(of("slow"), first_waits());
    ASSERT_TRUE(reaches(begun, 1));
  }
  obtain(of("victim"), first_waits());
  EXPECT_TRUE(reaches(made, 4)) << "the slow client gets it, too";
  EXPECT_EQ(begun, 2) << "one attempt for each client";
  dispatcher.wait_idle();  // the slow attempt was stopped, although nothing opened
  EXPECT_EQ(failed, 0);
}

TEST_F(CompressionsOfOneAnswer, AMoreUrgentRequestDoesNotWaitForALessUrgentAttempt) {
  constexpr double kLong = 1e6;
  obtain(of("client"), first_waits(), kLong);
  ASSERT_TRUE(reaches(begun, 1));
  obtain(of("client", Priority::kRealtime), first_waits(), kLong);
  EXPECT_TRUE(reaches(made, 2));
  EXPECT_EQ(begun, 2);
}

TEST_F(CompressionsOfOneAnswer, IfAnAttemptFailsTheOthersTryForThemselves) {
  const auto first_fails = [this](int attempt, const Execution& execution) {
    if (attempt > 1) return;
    wait_at_polls(execution);
    throw std::runtime_error("no luck");
  };
  constexpr double kLong = 1e6;
  obtain(of("client"), first_fails, kLong);
  ASSERT_TRUE(reaches(begun, 1));
  for (int k = 0; k < 2; ++k) obtain(of("client"), first_fails, kLong);
  open = true;
  EXPECT_TRUE(reaches(made, 2));
  EXPECT_TRUE(reaches(failed, 1));
  EXPECT_EQ(begun, 2);
}

TEST_F(CompressionsOfOneAnswer, AnAttemptGoesOnForTheOthersAndEndsWithTheLast) {
  constexpr double kLong = 1e6;
  std::stop_source first, second;
  Terms leaves = of("client");
  leaves.gone = first.get_token();
  obtain(leaves, first_waits(), kLong);
  ASSERT_TRUE(reaches(begun, 1));
  leaves.gone = second.get_token();
  obtain(leaves, first_waits(), kLong);
  first.request_stop();
  EXPECT_EQ(failed, 1);
  EXPECT_EQ(pool.running(), 1u);
  second.request_stop();
  EXPECT_EQ(failed, 2);
  dispatcher.wait_idle();  // although nothing opened
  EXPECT_EQ(begun, 1);
  EXPECT_EQ(made, 0);
}

// The same through HTTP. The first client's places are taken by computations that do not end.
TEST(CompressedAnswers, AClientWithLongComputationsDoesNotHoldUpTheAnswersOfOthers) {
  const std::string greedy = "127.0.0.2";
  std::atomic<int> computing{0};
  std::atomic<bool> open{false};
  TestServerOptions options;
  options.limits.deadline = options.limits.realtime_deadline = kPatience;
  TestServer server(options);
  server.control->glb_padding = 100'000;
  const std::string location = server.post("/fracture?sites=9").header("content-location");
  server.control->during_cut = [&](const Execution& execution) {
    ++computing;
    while (!open) {
      execution.poll();
      std::this_thread::yield();
    }
  };
  std::vector<std::unique_ptr<RawClient>> busy;
  for (const char* sites : {"10", "11"}) {
    busy.push_back(std::make_unique<RawClient>(server.port(), greedy));
    busy.back()->send(std::string("POST /fracture?sites=") + sites +
                      " HTTP/1.1\r\nHost: t\r\nContent-Type: model/gltf-binary\r\nContent-Length: 4\r\n\r\n"
                      "mesh");
  }
  EXPECT_TRUE(eventually(kPatience, "two computations", [&] { return computing == 2; }));
  const std::string get = "GET " + location + " HTTP/1.1\r\nHost: t\r\nAccept-Encoding: gzip\r\n\r\n";
  RawClient first(server.port(), greedy), victim(server.port());
  first.send(get);
  EXPECT_TRUE(eventually(kPatience, "the first request to wait", [&] { return server.pool.queued() == 1; }));
  victim.send(get);
  for (RawClient* const client : {&victim, &first}) {
    const auto reply = client->receive();
    EXPECT_TRUE(reply && reply->status == 200 && reply->header("content-encoding") == "gzip");
  }
  open = true;  // the computations had not ended before
  for (const auto& client : busy) EXPECT_TRUE(client->receive());
}

}  // namespace
}  // namespace fracture::test
