// No work waits for less urgent work: which task pauses and when, and that no task pauses forever.
#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <string>
#include <thread>

#include "server/service/worker_pool.hpp"
#include "tests/server/service/polling.hpp"
#include "tests/support/eventually.hpp"

namespace fracture {
namespace {

using test::kBackground, test::kBatch, test::kRealtime, test::Computing;

TEST(Turns, ARealtimeJobRunsWhileTheOnlyThreadsBatchJobStandsStill) {
  WorkerPool pool(1, 100);
  Computing batch(pool, 3);
  std::latch gate(1);
  std::atomic<bool> began{false};
  pool.submit(kRealtime, 0, [&](int) {
    began = true;
    gate.wait();
  });
  EXPECT_TRUE(test::eventually(test::kPatience, "the realtime job to begin", [&] { return began.load(); }));
  EXPECT_FALSE(batch.done);
  EXPECT_TRUE(
      test::eventually(test::kPatience, "the batch job to stand still", [&] { return pool.paused() == 1; }));
  gate.count_down();
  EXPECT_TRUE(
      test::eventually(test::kPatience, "the batch job to go on", [&] { return pool.paused() == 0; }));
  batch.end = true;
  pool.wait_idle();
  EXPECT_GT(batch.paused_seconds, 0);
}

TEST(Turns, AllThreadsOfAJobStandStill) {
  WorkerPool pool(2, 100);
  std::atomic<bool> end{false};
  std::atomic<long> polls[2] = {0, 0};
  pool.submit(kBatch, 0, [&](int) {
    Turn* const turn = WorkerPool::turn();
    const auto work = [&, turn](std::atomic<long>& mine) {
      while (!end) {
        turn->give_way();
        ++mine;
        std::this_thread::yield();
      }
    };
    std::thread helper([&] { work(polls[1]); });
    work(polls[0]);
    helper.join();
  });
  EXPECT_TRUE(
      test::eventually(test::kPatience, "both to compute", [&] { return polls[0] > 0 && polls[1] > 0; }));
  std::latch gate(1);
  std::atomic<int> realtime{0};
  for (int k = 0; k < 2; ++k)
    pool.submit(kRealtime, 0, [&](int) {
      ++realtime;
      gate.wait();
    });
  EXPECT_TRUE(test::eventually(test::kPatience, "both realtime jobs", [&] { return realtime == 2; }));
  // Time ends each pause. In some pauses neither thread polls again.
  EXPECT_TRUE(test::eventually(test::kPatience, "a pause in which nobody computes", [&] {
    if (pool.paused() == 0) return false;
    const long before = polls[0] + polls[1];
    // pause: a running computation would poll thousands of times
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return polls[0] + polls[1] <= before + 2 && pool.paused() == 1;
  }));
  gate.count_down();
  end = true;
  pool.wait_idle();
}

TEST(Turns, WithTwoThreadsARealtimeJobBeginsBesideBatchJobsThatNeverPoll) {
  std::latch gate(1);
  WorkerPool pool(2, 100);
  std::atomic<int> batch{0};
  for (int k = 0; k < 3; ++k)
    pool.submit(kBatch, 0, [&](int) {
      ++batch;
      gate.wait();
    });
  EXPECT_TRUE(test::eventually(test::kPatience, "both threads to be busy", [&] { return batch == 2; }));
  std::atomic<int> done{0};
  for (int k = 0; k < 10; ++k) pool.submit(kRealtime, 0, [&](int) { ++done; });
  EXPECT_TRUE(test::eventually(test::kPatience, "all the realtime jobs", [&] { return done == 10; }));
  EXPECT_EQ(batch, 2) << "the third waits for one of the two";
  gate.count_down();
  pool.wait_idle();
}

TEST(Turns, TheKeptThreadTakesOneAtATimeAndNoBatchJob) {
  std::latch gate(1);
  WorkerPool pool(2, 100);
  std::atomic<int> begun{0};
  const auto stay = [&](int) {
    ++begun;
    gate.wait();
  };
  for (int k = 0; k < 2; ++k) pool.submit(kBatch, 0, stay);
  EXPECT_TRUE(test::eventually(test::kPatience, "both threads to be busy", [&] { return begun == 2; }));
  for (int k = 0; k < 2; ++k) pool.submit(kRealtime, 0, stay);
  EXPECT_TRUE(test::eventually(test::kPatience, "two and one to begin", [&] { return begun == 3; }));
  EXPECT_EQ(pool.queued(), 1u);
  gate.count_down();
  pool.wait_idle();
  EXPECT_EQ(begun, 4);
}

TEST(Turns, ABatchJobDoesNotStandStillForEver) {
  std::latch gate(1);
  WorkerPool pool(1, 100);
  Computing batch(pool);
  std::atomic<bool> began{false};
  pool.submit(kRealtime, 0, [&](int) {
    began = true;
    gate.wait();  // as if it waited for something that the batch job holds
  });
  EXPECT_TRUE(test::eventually(test::kPatience, "the realtime job to begin", [&] { return began.load(); }));
  const long before = batch.polls;
  EXPECT_TRUE(test::eventually(test::kPatience, "the batch job to go on all the same",
                               [&] { return batch.polls > before + 10; }));
  gate.count_down();
  batch.end = true;
  pool.wait_idle();
}

TEST(Turns, BackgroundWorkStandsStillForBatchWork) {
  WorkerPool pool(1, 100);
  Computing background(pool, 2, kBackground);
  std::latch gate(1);
  std::atomic<bool> began{false};
  pool.submit(kBatch, 0, [&](int) {
    began = true;
    gate.wait();
  });
  EXPECT_TRUE(test::eventually(test::kPatience, "the batch job to begin", [&] { return began.load(); }));
  EXPECT_TRUE(
      test::eventually(test::kPatience, "the other to stand still", [&] { return pool.paused() == 1; }));
  const long before = background.polls;
  EXPECT_TRUE(test::eventually(test::kPatience, "it to go on all the same, for its fifth of the time",
                               [&] { return background.polls > before + 10; }));
  gate.count_down();
  background.end = true;
  pool.wait_idle();
}

TEST(Turns, EachClassStandsStillForThoseBeforeItAndNoneForLessUrgentOnes) {
  WorkerPool pool(1, 100);
  Computing background(pool, 1, kBackground);
  Computing batch(pool);
  std::latch gate(1);
  std::atomic<bool> began{false};
  pool.submit(kRealtime, 0, [&](int) {
    began = true;
    gate.wait();
  });
  EXPECT_TRUE(test::eventually(test::kPatience, "the realtime job to begin", [&] { return began.load(); }));
  EXPECT_TRUE(test::eventually(test::kPatience, "both to stand still", [&] { return pool.paused() == 2; }));
  gate.count_down();
  batch.end = true;
  EXPECT_TRUE(test::eventually(test::kPatience, "the batch job to end", [&] { return batch.done.load(); }));
  EXPECT_FALSE(background.done);
  background.end = true;
  pool.wait_idle();
}

TEST(Turns, BackgroundWorkIsQueuedForItself) {
  std::latch gate(1);
  WorkerPool pool(1, 2);
  pool.submit(kRealtime, 0, [&](int) { gate.wait(); });
  EXPECT_TRUE(
      test::eventually(test::kPatience, "the thread to be busy", [&] { return pool.running() == 1; }));
  std::string order;
  WorkerPool::TaskId last = 0;
  for (const char name : {'1', '2', '3'})
    last = pool.submit(kBackground, 1000, [&order, name](int) { order += name; });
  EXPECT_TRUE(pool.full(kBackground));
  EXPECT_FALSE(pool.full(kBatch) || pool.full(kRealtime));
  EXPECT_LT(pool.predicted_wait(kBatch).count(), 1) << "what stands back is not waited for";
  EXPECT_GT(pool.predicted_wait(kBackground).count(), 1000);
  pool.submit(kBatch, 1, [&](int) { order += 'b'; });
  EXPECT_EQ(pool.positions({last}).front(), 3u);
  EXPECT_TRUE(pool.reclassify(last, kBatch));
  EXPECT_FALSE(pool.reclassify(last, kBatch)) << "it is one already";
  gate.count_down();
  pool.wait_idle();
  EXPECT_EQ(order, "3b12") << "among the batch jobs by its arrival";
}

TEST(Turns, BackgroundJobsThatRunFillNoQueue) {
  std::latch gate(1);
  WorkerPool pool(2, 0);
  for (int k = 0; k < 2; ++k) pool.submit(kBackground, 0, [&](int) { gate.wait(); });
  EXPECT_TRUE(test::eventually(test::kPatience, "both to run", [&] { return pool.running() == 2; }));
  EXPECT_FALSE(pool.full(kRealtime) || pool.full(kBatch));
  EXPECT_TRUE(pool.full(kBackground));
  gate.count_down();
  pool.wait_idle();
}

TEST(Turns, JobsThatAreAwayLeaveThreadsToRealtimeOnes) {
  std::latch gate(1);
  std::atomic<bool> away[3] = {false, false, false}, realtime{false};
  WorkerPool pool(1, 100);
  for (int k = 0; k < 3; ++k) {
    pool.submit(k == 1 ? kBatch : kBackground, 0, [&gate, &mine = away[k]](int) {
      const Away elsewhere(WorkerPool::turn());
      mine = true;
      gate.wait();
    });
    if (k < 2) {
      EXPECT_TRUE(test::eventually(test::kPatience, "it to be away", [&] { return away[k].load(); }));
    }
  }
  pool.submit(kRealtime, 0, [&](int) { realtime = true; });
  EXPECT_TRUE(test::eventually(test::kPatience, "the realtime job", [&] { return realtime.load(); }));
  EXPECT_FALSE(away[2]) << "the last thread is for realtime jobs";
  gate.count_down();
  pool.wait_idle();
  EXPECT_TRUE(away[2]);
}

TEST(Turns, AStandingJobThatBecomesRealtimeGoesOn) {
  std::latch gate(1);
  WorkerPool pool(1, 100);
  Computing batch(pool);
  std::atomic<bool> began{false};
  pool.submit(kRealtime, 0, [&](int) {
    began = true;
    gate.wait();
  });
  EXPECT_TRUE(test::eventually(test::kPatience, "the realtime job to begin", [&] { return began.load(); }));
  pool.reclassify(batch.id, kRealtime);
  const long before = batch.polls;
  EXPECT_TRUE(test::eventually(test::kPatience, "it to go on", [&] { return batch.polls > before + 1000; }));
  EXPECT_EQ(pool.paused(), 0u);
  batch.end = true;
  gate.count_down();
  pool.wait_idle();
}

TEST(Turns, WhoIsAwayLeavesItsProcessorToRealtimeWorkAndToNoOther) {
  std::latch gate(1);
  WorkerPool pool(1, 100);
  std::atomic<bool> away{false}, back{false}, other{false};
  double elsewhere = 0;
  pool.submit(kBatch, 0, [&](int) {
    {
      const Away mine(WorkerPool::turn());
      away = true;
      gate.wait();
      WorkerPool::turn()->spent_elsewhere(2.5);
    }
    elsewhere = WorkerPool::seconds_elsewhere();
    back = true;
  });
  EXPECT_TRUE(test::eventually(test::kPatience, "it to be away", [&] { return away.load(); }));
  pool.submit(kBatch, 0, [&](int) { other = true; });
  std::atomic<bool> realtime{false};
  pool.submit(kRealtime, 0, [&](int) { realtime = true; });
  EXPECT_TRUE(test::eventually(test::kPatience, "the realtime job", [&] { return realtime.load(); }));
  EXPECT_FALSE(other || back);
  gate.count_down();
  pool.wait_idle();
  EXPECT_TRUE(other && back);
  EXPECT_EQ(elsewhere, 2.5) << "whatever it waited";
}

TEST(Turns, NobodyIsLostWhenAllComeAtOnce) {
  WorkerPool pool(2, 1000);
  std::atomic<int> done{0};
  std::vector<std::thread> clients;
  for (int t = 0; t < 4; ++t)
    clients.emplace_back([&, t] {
      for (int k = 0; k < 200; ++k) {
        const Priority priority = static_cast<Priority>((k + t) % 3);
        const auto id = pool.submit(priority, 0.001,
                                    [&](int) {
                                      for (int poll = 0; poll < 20; ++poll) WorkerPool::turn()->give_way();
                                      ++done;
                                    },
                                    {std::to_string(t), 1});
        if (k % 7 == 0) pool.reclassify(id, static_cast<Priority>(t % 2));
      }
    });
  for (std::thread& client : clients) client.join();
  pool.wait_idle();
  EXPECT_EQ(done, 800);
  EXPECT_EQ(pool.running(), 0u);
}

TEST(Turns, AResumedTaskIsPromotedToo) {
  std::latch gate(1);
  WorkerPool pool(1, 100);
  pool.submit(kBatch, 0, [&](int) { gate.wait(); });
  test::require_eventually(test::kPatience, "a job to run", [&] { return pool.running() > 0; });
  std::string order;
  pool.resume([&](int) { order += 'b'; }, kBatch);
  const WorkerPool::TaskId hurried = pool.resume([&](int) { order += 'h'; }, kBatch);
  EXPECT_FALSE(pool.reclassify(hurried, kRealtime)) << "its turn has come before";
  gate.count_down();
  pool.wait_idle();
  EXPECT_EQ(order, "hb");
}

}  // namespace
}  // namespace fracture
