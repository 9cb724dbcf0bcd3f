// A fixture for tests of the dispatcher: a fake engine on two threads, and the outcome of each request.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "server/service/dispatcher.hpp"
#include "tests/server/support/fake_engine.hpp"
#include "tests/server/support/fracture_request.hpp"
#include "tests/server/support/gate.hpp"

namespace fracture::test {

struct DispatcherTest : testing::Test {
  std::shared_ptr<FakeControl> control = std::make_shared<FakeControl>();
  FractureService service{ServiceConfig{}, std::make_unique<FakeEngine>(control)};
  WorkerPool pool{2, 256};
  Dispatcher dispatcher{service, pool};
  std::atomic<int> good{0}, bad{0};
  std::mutex mutex;
  std::map<ErrorCode, int> errors;
  std::map<CacheOutcome, int> outcomes;

  void ask(FractureRequest r, const Terms& terms = {}) {
    const auto overload = dispatcher.fracture(std::move(r), terms, [this](Expected<FractureAnswer> answer) {
      const std::lock_guard lock(mutex);
      if (answer)
        ++outcomes[answer->result_cache];
      else
        ++errors[answer.error().code];
      ++(answer ? good : bad);
    });
    EXPECT_FALSE(overload) << overload->detail;
  }
};

}  // namespace fracture::test
