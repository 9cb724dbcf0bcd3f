// Counts the polls of a computation, and interrupts it at one of them.
#pragma once

#include <stop_token>

#include "common/base/execution.hpp"

namespace fracture::test {

struct Polls {
  /// `stop_at_poll`: the computation is stopped at its poll with this number, counted from 1. 0: never.
  explicit Polls(int stop_at_poll = 0) : stop_at(stop_at_poll) {
    execution.watch = [this] {
      if (++count == stop_at) stop.request_stop();
    };
    execution.stop = stop.get_token();
  }
  Polls(const Polls&) = delete;
  Polls& operator=(const Polls&) = delete;

  std::stop_source stop;
  Execution execution;
  int count = 0, stop_at = 0;
};

}  // namespace fracture::test
