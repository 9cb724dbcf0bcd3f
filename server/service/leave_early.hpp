// The two ways in which a wait ends before its answer arrives: the deadline passes, or the client leaves.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "server/service/dispatcher.hpp"
#include "server/service/timer.hpp"

namespace fracture {

/// A member of the object that waits. The timer and the stop callback have only weak pointers to that object, so they do not
/// keep it alive.
class LeaveEarly {
 public:
  explicit LeaveEarly(Timer& timer) : timer_(timer) {}
  ~LeaveEarly() {
    if (alarm_) timer_.cancel(*alarm_);
  }
  LeaveEarly(const LeaveEarly&) = delete;
  LeaveEarly& operator=(const LeaveEarly&) = delete;

  /// Arranges for waiter->leave() to be called: with kDeadlineExceeded at the deadline, and with kCancelled when the client
  /// leaves. Both calls may happen. They may come from any thread, even before this function returns.
  template <class Waiter>
  void arm(std::weak_ptr<Waiter> waiter, const Terms& terms) {
    const auto leave_with = [waiter = std::move(waiter)](ErrorCode code) {
      if (const auto self = waiter.lock()) self->leave(code);
    };
    if (terms.deadline != Timer::Clock::time_point::max())
      alarm_ = timer_.at(terms.deadline, [leave_with] { leave_with(ErrorCode::kDeadlineExceeded); });
    gone_.emplace(terms.gone, [leave_with] { leave_with(ErrorCode::kCancelled); });
  }

 private:
  Timer& timer_;
  std::optional<Timer::Id> alarm_;
  std::optional<std::stop_callback<std::function<void()>>> gone_;
};

}  // namespace fracture
