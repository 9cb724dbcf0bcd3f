// Who waits for what somebody else computes hurries it, for as long as they wait.
#include "server/service/urgency.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <latch>
#include <thread>

#include "server/service/dispatcher.hpp"
#include "tests/server/fake_engine.hpp"
#include "tests/server/fracture_request.hpp"
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

  Urgency job, part;
  job.lead(pool, {{"job", 1}, Priority::kBackground, 0}, [&] { return task; });
  part.lead_part(pool, task, job.priority());
  part.join(pool, Priority::kBatch, {"client", 1});
  EXPECT_TRUE(eventually(kPatience, "it to go on", [&] { return pool.paused() == 0; }));
  part.join(pool, Priority::kRealtime, {"game", 1});
  const long before = polls;
  EXPECT_TRUE(eventually(kPatience, "it to compute", [&] { return polls > before + 1000; }));
  EXPECT_EQ(pool.paused(), 0u);

  part.end_part();
  job.restore(pool);
  EXPECT_EQ(job.priority(), Priority::kBackground);
  EXPECT_TRUE(eventually(kPatience, "it to stand still again", [&] { return pool.paused() == 1; }));
  part.join(pool, Priority::kRealtime, {"late", 1});
  gate.count_down();
  end = true;
  pool.wait_idle();
}

TEST(Urgency, WhoHurriesAResultHurriesWhatItWaitsFor) {
  WorkerPool pool(1, 100);
  std::latch gate(1);
  pool.submit(Priority::kRealtime, 0, [&](int) { gate.wait(); });
  ASSERT_TRUE(eventually(kPatience, "the thread to be busy", [&] { return pool.running() == 1; }));
  std::string order;
  pool.submit(Priority::kBatch, 0, [&](int) { order += 'b'; });
  Urgency mesh, result;
  mesh.lead(pool, {{"job", 1}, Priority::kBackground, 0},
            [&] { return pool.submit(Priority::kBackground, 0, [&](int) { order += 'm'; }); });
  result.lead(pool, {{"job", 1}, Priority::kBackground, 0}, [] { return WorkerPool::TaskId{0}; });
  result.waits_for([&](Priority priority, const Flow& flow) { mesh.join(pool, priority, flow); });
  EXPECT_EQ(mesh.turn().priority, Priority::kBackground);
  result.join(pool, Priority::kRealtime, {"game", 1});
  EXPECT_EQ(mesh.priority(), Priority::kRealtime);
  EXPECT_EQ(mesh.turn().flow.name, "game") << "whose turn it takes is charged for it";
  result.goes_on([&](Priority priority) {
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
    // pause: so that it asks before it is known
    seen.wait_for(std::chrono::milliseconds(20));
    return number;
  };
  result.lead(pool, {{"job", 1}, Priority::kBatch, 0}, [&] { return begins_at_once(7); });
  EXPECT_EQ(seen.get(), 7u);
  result.goes_on([&](Priority) { return begins_at_once(8); });
  EXPECT_EQ(seen.get(), 8u);
}

}  // namespace
}  // namespace fracture::test
