// Where computations of a fake engine stay until the test lets them go.
#pragma once

#include <atomic>
#include <functional>

#include "common/base/execution.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::test {

/// Holds whoever passes until it is opened.
struct Gate {
  std::atomic<int> arrived{0};
  std::atomic<bool> open{false};

  /// An interruption gets through, and more urgent work is done meanwhile.
  void pass(const Execution& execution) {
    wait([&execution] { execution.poll(); });
  }
  void pass_without_polls() {
    wait([] {});
  }
  /// pass(), as a hook of FakeControl.
  std::function<void(const Execution&)> hook() {
    return [this](const Execution& execution) { pass(execution); };
  }
  /// Until so many have come.
  void wait_for(int n) const {
    require_eventually(kPatience, "computations to come to the gate", [&] { return arrived >= n; });
  }

 private:
  template <class Poll>
  void wait(const Poll& poll) {
    ++arrived;
    require_eventually(kPatience, "the gate to open", [&] {
      poll();
      return open.load();
    });
  }
};

}  // namespace fracture::test
