// A client that waits for another client's computation hurries it for as long as it waits.
#include "server/service/urgency.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <latch>
#include <memory>
#include <stop_token>
#include <thread>

#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

TEST(Urgency, ACollisionHurriesThePreparationThatItWaitsFor) {
  const auto control = std::make_shared<FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(control)};
  WorkerPool pool{1, 256};
  Dispatcher dispatcher{service, pool};
  std::atomic<bool> first{true}, at_gate{false}, open{false};
  control->during_cut = [&](const Execution& execution) {
    if (!first.exchange(false)) return;
    at_gate = true;
    require_eventually(kPatience, "the gate to open", [&] {
      execution.poll();
      return open.load();
    });
  };
  std::atomic<int> answered{0}, hurried{0}, prepared{0};
  const auto count = [](std::atomic<int>& good) {
    return [&good](const auto& answer) { good += answer.has_value(); };
  };
  EXPECT_FALSE(dispatcher.fracture(fracture_request("long"), {}, count(answered)));
  ASSERT_TRUE(eventually(kPatience, "a batch computation", [&] { return at_gate.load(); }));
  EXPECT_FALSE(dispatcher.prepare(fracture_request("mesh"), {}, count(prepared)));
  Terms realtime;
  realtime.priority = Priority::kRealtime;
  EXPECT_FALSE(dispatcher.fracture(fracture_request("mesh", 2), realtime, count(hurried)));
  EXPECT_TRUE(eventually(kPatience, "the collision's answer", [&] { return hurried == 1; }));
  EXPECT_EQ(prepared, 1);
  EXPECT_EQ(answered, 0) << "what they went before stands still";
  open = true;
  dispatcher.wait_idle();
  EXPECT_EQ(answered, 1);
}

TEST(Urgency, APartOfAJobIsAsUrgentAsWhoWaitsForItAndTheRestIsNot) {
  WorkerPool pool(1, 100);
  std::atomic<bool> end{false};
  std::atomic<long> polls{0};
  const WorkerPool::TaskId task = pool.submit(Priority::kBackground, 0, [&](int) {
    while (!end) {
      WorkerPool::turn()->give_way();
      ++polls;
      std::this_thread::yield();
    }
  });
  ASSERT_TRUE(eventually(kPatience, "the job", [&] { return polls > 0; }));
  std::latch gate(1);
  pool.submit(Priority::kBatch, 0, [&](int) { gate.wait(); });
  EXPECT_TRUE(eventually(kPatience, "it to stand still", [&] { return pool.paused() == 1; }));

  Urgency job;
  const auto part = std::make_shared<Urgency>();
  job.lead(pool, {"job", 1}, Priority::kBackground, [&] { return task; });
  job.lead_part(pool, part);
  part->join(pool, Priority::kBatch, {"client", 1});
  EXPECT_TRUE(eventually(kPatience, "it to go on", [&] { return pool.paused() == 0; }));
  part->join(pool, Priority::kRealtime, {"game", 1});
  const long before = polls;
  EXPECT_TRUE(eventually(kPatience, "it to compute", [&] { return polls > before + 1000; }));
  EXPECT_EQ(pool.paused(), 0u);

  job.end_part(pool, *part);
  EXPECT_EQ(job.priority(), Priority::kBackground);
  EXPECT_TRUE(eventually(kPatience, "it to stand still again", [&] { return pool.paused() == 1; }));
  part->join(pool, Priority::kRealtime, {"late", 1});
  gate.count_down();
  end = true;
  pool.wait_idle();
}

/// Other threads ask for the class of a task that has given up its part and has not ended yet.
TEST(Urgency, OfATaskThatGaveUpItsPartIsThatOfItsResult) {
  WorkerPool pool(1, 100);
  std::latch gate(1);
  const WorkerPool::TaskId task = pool.submit(Priority::kBatch, 0, [&](int) { gate.wait(); });
  Urgency job;
  const auto part = std::make_shared<Urgency>();
  job.lead(pool, {"job", 1}, Priority::kBatch, [&] { return task; });
  job.lead_part(pool, part);
  part->join(pool, Priority::kRealtime, {"game", 1});
  EXPECT_EQ(job.priority_of_task(), Priority::kRealtime);
  EXPECT_TRUE(job.computes_for_others());
  job.gives_up(pool);
  EXPECT_EQ(job.priority_of_task(), Priority::kBatch);
  EXPECT_FALSE(job.computes_for_others());
  EXPECT_FALSE(job.stands_still());
  job.end_part(pool, *part);
  gate.count_down();
  pool.wait_idle();
}

TEST(Urgency, WhoHurriesAResultHurriesWhatItWaitsFor) {
  WorkerPool pool(1, 100);
  std::latch gate(1);
  pool.submit(Priority::kRealtime, 0, [&](int) { gate.wait(); });
  ASSERT_TRUE(eventually(kPatience, "the thread to be busy", [&] { return pool.running() == 1; }));
  std::string order;
  pool.submit(Priority::kBatch, 0, [&](int) { order += 'b'; });
  Urgency result;
  const auto mesh = std::make_shared<Urgency>();
  mesh->lead(pool, {"job", 1}, Priority::kBackground,
             [&] { return pool.submit(Priority::kBackground, 0, [&](int) { order += 'm'; }); });
  result.lead(pool, {"job", 1}, Priority::kBackground, [] { return WorkerPool::TaskId{0}; });
  result.waits_for(pool, mesh);
  result.join(pool, Priority::kRealtime, {"game", 1});
  EXPECT_EQ(mesh->priority(), Priority::kRealtime);
  result.goes_on(pool, [&](Priority priority, const Flow&) {
    EXPECT_EQ(priority, Priority::kRealtime);
    return WorkerPool::TaskId{0};
  });
  gate.count_down();
  pool.wait_idle();
  EXPECT_EQ(order, "mb");
}

TEST(Urgency, ATaskThatBeginsBeforeItsNumberIsKnownLearnsIt) {
  WorkerPool pool(1, 100);
  Urgency result;
  std::future<WorkerPool::TaskId> seen;
  const auto begins_at_once = [&](WorkerPool::TaskId number) {
    std::atomic<bool> asks{false};
    seen = std::async(std::launch::async, [&] {
      asks = true;
      return result.task();
    });
    require_eventually(kPatience, "the task to begin", [&] { return asks.load(); });
    // pause: so that the task asks before its number is known
    seen.wait_for(std::chrono::milliseconds(20));
    return number;
  };
  result.lead(pool, {"job", 1}, Priority::kBatch, [&] { return begins_at_once(7); });
  EXPECT_EQ(seen.get(), 7u);
  result.goes_on(pool, [&](Priority, const Flow&) { return begins_at_once(8); });
  EXPECT_EQ(seen.get(), 8u);
}

TEST(Urgency, AQueuedTaskGoesBackToItsClassWhenWhoHurriedItLeaves) {
  WorkerPool pool(1, 100);
  std::latch gate(1);
  pool.submit(Priority::kRealtime, 0, [&](int) { gate.wait(); });
  ASSERT_TRUE(eventually(kPatience, "the thread to be busy", [&] { return pool.running() == 1; }));
  std::string order;
  Urgency job;
  job.lead(pool, {"job", 1}, Priority::kBackground, [&] {
    return pool.submit(Priority::kBackground, 0, [&](int) { order += 'j'; }, {"job", 1});
  });
  pool.submit(Priority::kBatch, 0, [&](int) { order += 'b'; });
  job.join(pool, Priority::kRealtime, {"game", 1});
  job.join(pool, Priority::kBatch, {"client", 1});
  job.leave(pool, Priority::kRealtime);
  EXPECT_EQ(job.priority(), Priority::kBatch);
  job.leave(pool, Priority::kBatch);
  job.leave(pool, Priority::kBackground);
  EXPECT_EQ(job.priority(), Priority::kBackground) << "it is being stopped";
  gate.count_down();
  pool.wait_idle();
  EXPECT_EQ(order, "bj");
}

TEST(Urgency, WhoLeavesTheLeaderStaysAsUrgentAsThoseWhoStillWait) {
  WorkerPool pool(1, 100);
  Urgency result;
  result.join(pool, Priority::kBatch, {"early", 1});
  result.join(pool, Priority::kRealtime, {"game", 1});
  result.leave(pool, Priority::kRealtime);
  result.lead(pool, {"leader", 1}, Priority::kBackground, [] { return WorkerPool::TaskId{0}; });
  EXPECT_EQ(result.priority(), Priority::kBatch) << "who joined before the leader had its task counts";
  result.leave(pool, Priority::kBackground);
  EXPECT_EQ(result.priority(), Priority::kBatch);
}

TEST(Urgency, APartIsHurriedNoLongerThanTheResultsThatNeedIt) {
  WorkerPool pool(1, 100);
  const auto lead = [&](Urgency& result, Priority priority) {
    result.lead(pool, {"leader", 1}, priority, [] { return WorkerPool::TaskId{0}; });
  };
  Urgency job, collision;
  const auto part = std::make_shared<Urgency>();
  lead(job, Priority::kBackground);
  job.lead_part(pool, part);
  lead(collision, Priority::kBatch);
  collision.waits_for(pool, part);
  EXPECT_EQ(part->priority(), Priority::kBatch);
  collision.join(pool, Priority::kRealtime, {"game", 1});
  job.join(pool, Priority::kRealtime, {"game", 1});
  EXPECT_EQ(part->priority(), Priority::kRealtime);
  collision.leave(pool, Priority::kRealtime);
  EXPECT_EQ(part->priority(), Priority::kRealtime) << "the job's own client";
  job.leave(pool, Priority::kRealtime);
  EXPECT_EQ(part->priority(), Priority::kBatch);
  EXPECT_EQ(job.priority(), Priority::kBackground);
  collision.gives_up(pool);
  EXPECT_EQ(part->priority(), Priority::kBackground);
  collision.join(pool, Priority::kRealtime, {"game", 1});
  EXPECT_EQ(part->priority(), Priority::kBackground) << "it needs the part no longer";
  job.end_part(pool, *part);
}

// A part may end before a task has registered that it waits for it. The late registration then has no effect:
// the task waits for the next part.
TEST(Urgency, WhoComesTooLateToWaitForAPartWaitsForTheNextOne) {
  WorkerPool pool(1, 100);
  const auto lead = [&](Urgency& result) {
    result.lead(pool, {"leader", 1}, Priority::kBackground, [] { return WorkerPool::TaskId{0}; });
  };
  Urgency result;
  const auto mesh = std::make_shared<Urgency>(), diagram = std::make_shared<Urgency>();
  lead(result);
  lead(*mesh);
  lead(*diagram);
  mesh->end();
  result.goes_on(pool, [](Priority, const Flow&) { return WorkerPool::TaskId{0}; });
  result.waits_for(pool, diagram);
  result.waits_for(pool, mesh);  // too late
  result.join(pool, Priority::kRealtime, {"game", 1});
  EXPECT_EQ(diagram->priority(), Priority::kRealtime);
  EXPECT_EQ(mesh->priority(), Priority::kBackground);
}

/// One thread, and a background job that polls at a gate. More urgent requests are answered meanwhile.
struct AJobAtTheGate : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(control)};
  WorkerPool pool{1, 256};
  Dispatcher dispatcher{service, pool};
  std::atomic<bool> first{true}, at_gate{false}, open{false};
  std::atomic<int> finished{0}, answered{0}, cancelled{0};
  std::stop_source gone;

  void pass(const Execution& execution) {
    if (!first.exchange(false)) return;
    at_gate = true;
    require_eventually(kPatience, "the gate to open", [&] {
      execution.poll();
      return open.load();
    });
  }
  void begin_the_job() {
    Terms terms;
    terms.priority = Priority::kBackground;
    ask(fracture_request("long"), terms, finished);
    ASSERT_TRUE(eventually(kPatience, "the job at the gate", [&] { return at_gate.load(); }));
  }
  void ask(FractureRequest request, const Terms& terms, std::atomic<int>& good) {
    EXPECT_FALSE(dispatcher.fracture(std::move(request), terms, [&](Expected<FractureAnswer> answer) {
      if (answer)
        ++good;
      else
        cancelled += answer.error().code == ErrorCode::kCancelled;
    }));
  }
  /// Terms of a client that hurries the job. It leaves with `gone`.
  Terms hurried() const {
    Terms terms;
    terms.priority = Priority::kRealtime;
    terms.gone = gone.get_token();
    return terms;
  }
  void others_are_answered() {
    Terms realtime;
    realtime.priority = Priority::kRealtime;
    ask(fracture_request("collision"), realtime, answered);
    EXPECT_TRUE(eventually(kPatience, "a collision's answer", [&] { return answered == 1; }));
    ask(fracture_request("batch"), {}, answered);
    EXPECT_TRUE(eventually(kPatience, "a batch answer", [&] { return answered == 2; }));
    EXPECT_EQ(finished, 0) << "the job stands still for both";
    open = true;
    dispatcher.wait_idle();
    EXPECT_EQ(finished, 1);
  }
};

TEST_F(AJobAtTheGate, IsHurriedByWhoWaitsForTheSameAndNotWhenTheyHaveLeft) {
  control->during_cut = [&](const Execution& execution) { pass(execution); };
  begin_the_job();
  for (int k = 0; k < 3; ++k) ask(fracture_request("long"), hurried(), answered);
  gone.request_stop();
  EXPECT_EQ(cancelled, 3);
  others_are_answered();
}

TEST_F(AJobAtTheGate, IsHurriedByWhoWaitsForItWithADeadlineAndNotBeyondThat) {
  control->during_cut = [&](const Execution& execution) { pass(execution); };
  begin_the_job();
  Terms hasty = hurried();
  hasty.deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
  ask(fracture_request("long"), hasty, answered);
  EXPECT_TRUE(eventually(kPatience, "it to give up", [&] { return dispatcher.figures().abandoned == 1; }));
  others_are_answered();
}

TEST_F(AJobAtTheGate, IsHurriedInAPartByWhoWaitsForThatAndNotWhenTheyHaveLeft) {
  control->during_import = [&](const Execution& execution) { pass(execution); };
  begin_the_job();
  ask(fracture_request("long", 2), hurried(), answered);  // another result for the same mesh
  EXPECT_TRUE(eventually(kPatience, "it to wait for the mesh",
                         [&] { return pool.queued() == 0 && pool.running() == 1; }));
  gone.request_stop();
  EXPECT_EQ(cancelled, 1);
  others_are_answered();
}

TEST_F(AJobAtTheGate, IsHurriedInAPartByWhoWaitsForTheSameAndNotWhenTheyHaveLeft) {
  control->during_import = [&](const Execution& execution) { pass(execution); };
  begin_the_job();
  ask(fracture_request("long"), hurried(), answered);
  gone.request_stop();
  EXPECT_EQ(cancelled, 1);
  others_are_answered();
}

}  // namespace
}  // namespace fracture::test
