// Requests that wait for the same computation: what each leaves behind, and how the failure of one affects
// the others.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <new>
#include <stop_token>

#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// A progress callback. One of its copies fails for lack of memory.
struct Unlucky {
  Unlucky() = default;
  Unlucky(const Unlucky& other) : copies(other.copies) {
    if (*copies > 0 && copies->fetch_sub(1) == 1) throw std::bad_alloc();
  }
  void operator()(Stage, double) const {}

  std::shared_ptr<std::atomic<int>> copies = std::make_shared<std::atomic<int>>(0);  ///< until a copy fails
};

/// A request for "mesh" that is computed up to a gate.
struct Waiters : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(control)};
  WorkerPool pool{2, 256};
  Dispatcher dispatcher{service, pool};
  std::atomic<bool> at_gate{false}, open{false};
  std::atomic<int> good{0}, out_of_memory{0};

  Waiters() {
    control->during_cut = [this](const Execution& execution) {
      at_gate = true;
      require_eventually(kPatience, "the gate to open", [&] {
        execution.poll();
        return open.load();
      });
    };
  }
  void ask(const Terms& terms = {}) {
    EXPECT_FALSE(
        dispatcher.fracture(fracture_request("mesh"), terms, [this](Expected<FractureAnswer> answer) {
          if (answer)
            ++good;
          else
            out_of_memory += answer.error().code == ErrorCode::kOutOfMemory;
        }));
  }
  void begin() {
    ask();
    ASSERT_TRUE(eventually(kPatience, "the computation to begin", [&] { return at_gate.load(); }));
  }
  void end() {
    open = true;
    dispatcher.wait_idle();
  }
};

TEST_F(Waiters, WhoComesAndGoesLeavesNothingBehind) {
  begin();
  const auto held = std::make_shared<int>();
  for (int k = 0; k < 50; ++k) {
    std::stop_source gone;
    Terms terms;
    terms.gone = gone.get_token();
    terms.progress = [held](Stage, double) {};
    ask(terms);
    gone.request_stop();
  }
  EXPECT_EQ(held.use_count(), 1);
  end();
  EXPECT_EQ(good, 1);
}

TEST_F(Waiters, ALeaderThatCannotBeginAnswersAllAndBlocksNobody) {
  open = true;
  const Unlucky unlucky;
  Terms terms;
  terms.progress = unlucky;
  *unlucky.copies = 1;
  ask(terms);
  EXPECT_EQ(out_of_memory, 1);
  EXPECT_EQ(dispatcher.figures().flights, 0u);
  EXPECT_EQ(dispatcher.figures().working_bytes, 0u);
  ask(terms);
  EXPECT_TRUE(eventually(kPatience, "the next answer", [&] { return good == 1; }));
}

TEST_F(Waiters, AFollowerThatCannotWaitCostsNobodyElseTheirAnswer) {
  begin();
  const Unlucky unlucky;
  Terms terms;
  terms.progress = unlucky;
  *unlucky.copies = 1;
  ask(terms);
  EXPECT_EQ(out_of_memory, 1);
  EXPECT_EQ(good, 0);
  end();
  EXPECT_EQ(good, 1);
}

TEST_F(Waiters, APreparationThatLacksMemoryAnywhereIsAnsweredOnce) {
  for (const int copy : {1, 2}) {  // the copy for the queue, the copy for the run
    const Unlucky unlucky;
    Terms terms;
    terms.progress = unlucky;
    *unlucky.copies = copy;
    std::atomic<int> answers{0}, prepared{0};
    const auto prepare = [&] {
      EXPECT_FALSE(
          dispatcher.prepare(fracture_request("mesh " + std::to_string(copy)), terms, [&](auto mesh) {
            ++answers;
            if (mesh)
              ++prepared;
            else
              out_of_memory += mesh.error().code == ErrorCode::kOutOfMemory;
          }));
      dispatcher.wait_idle();
    };
    prepare();
    EXPECT_EQ(answers, 1) << copy;
    EXPECT_EQ(out_of_memory, copy);
    prepare();
    EXPECT_EQ(answers, 2) << copy;
    EXPECT_EQ(prepared, 1) << copy;
  }
  EXPECT_EQ(pool.escaped(), 0u);
}

}  // namespace
}  // namespace fracture::test
