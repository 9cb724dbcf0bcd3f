// Those who wait for one computation: what each of them leaves behind, and what its failure costs the others.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stop_token>

#include "server/service/dispatcher.hpp"
#include "tests/server/fake_engine.hpp"
#include "tests/server/fracture_request.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {
namespace {

/// One request of "mesh" that is being computed, up to a gate.
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

}  // namespace
}  // namespace fracture::test
