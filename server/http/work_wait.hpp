// How a connection waits for work that is done elsewhere, and learns that its client is gone.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// Used from the connection's strand only. Held by shared_ptr: the watch on the socket may outlive the wait.
class WorkWait : public std::enable_shared_from_this<WorkWait> {
 public:
  explicit WorkWait(std::shared_ptr<TimedSocket> connection);

  /// Before the work starts. The token is asked to stop when the client resets the connection, or by
  /// cancel().
  std::stop_token begin();
  /// Looks again whether what is waited for is there.
  void wake() { woken_.cancel(); }
  /// Also of all that begins later.
  void cancel() {
    cancelled_ = true;
    stop_.request_stop();
  }

  /// Waits until `done`, which is asked again after each wake(). A reset wakes, too. `done` outlives the wait and
  /// has a name: g++ 12 destroys a temporary twice that is an argument of what is awaited.
  asio::awaitable<void> until(const std::function<bool()>& done);

  bool stopped() const { return stop_.stop_requested(); }
  /// The client reset the connection during the wait. A half-close is none: that client still reads.
  bool was_reset() const { return reset_; }

 private:
  void watch_for_reset();

  const std::shared_ptr<TimedSocket> connection_;
  asio::steady_timer woken_;  // never expires: cancelled to wake
  std::stop_source stop_;
  bool reset_ = false, cancelled_ = false, watching_ = false;
};

}  // namespace fracture::http
