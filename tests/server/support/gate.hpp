// A gate that holds the computations of a fake engine until the test releases them.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "common/base/execution.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

/// Holds every computation that arrives, until it is opened. It opens when it is destroyed. A hook may
/// outlive its gate, because a server that is declared before the gate still computes after the gate is
/// destroyed.
class Gate {
  struct State {
    std::atomic<int> arrived{0};
    std::atomic<bool> open{false};
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();

 public:
  std::atomic<int>& arrived = state_->arrived;
  std::atomic<bool>& open = state_->open;

  Gate() = default;
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;
  ~Gate() { open = true; }

  /// Waits and polls: an interruption passes through, and more urgent work is done meanwhile.
  void pass(const Execution& execution) {
    wait(*state_, [&execution] { execution.poll(); });
  }
  void pass_without_polls() {
    wait(*state_, [] {});
  }
  /// pass() as a hook for FakeControl.
  std::function<void(const Execution&)> hook() {
    return [state = state_](const Execution& execution) { wait(*state, [&execution] { execution.poll(); }); };
  }
  std::function<void(const Execution&)> hook_without_polls() {
    return [state = state_](const Execution&) { wait(*state, [] {}); };
  }
  /// Waits until n computations have arrived.
  void wait_for(int n) const {
    require_eventually(kPatience, "computations to come to the gate", [&] { return arrived >= n; });
  }

 private:
  template <class Poll>
  static void wait(State& state, const Poll& poll) {
    ++state.arrived;
    require_eventually(kPatience, "the gate to open", [&] {
      poll();
      return state.open.load();
    });
  }
};

}  // namespace fracture::test
