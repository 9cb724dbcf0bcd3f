// Lets a connection wait for work that is done elsewhere, and notices if its client leaves.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include "server/http/problem.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// Meaning of a client closing its side of the connection while it waits.
enum class HalfClose {
  kIsGone,      ///< it cancels its request
  kStillReads,  ///< nothing: it has announced this (Half-Close: yes)
};

/// The problem for a client that has cancelled its request but still reads.
Problem client_closed();

/// Use only from the connection's strand. Held by shared_ptr, because the watch on the socket may outlive the
/// wait.
///
/// The end of a stream can only be seen after all data before it was read. So data that a client sends while
/// it waits (pipelined requests) is read while the buffer has room. When the buffer is full, only a reset is
/// noticed, because with unread data every wait for the end of the stream would return at once.
class WorkWait : public std::enable_shared_from_this<WorkWait> {
 public:
  /// `ahead` receives the data read during a wait. It must outlive every wait, and nothing else may use it
  /// then.
  WorkWait(std::shared_ptr<TimedSocket> connection, beast::flat_buffer& ahead);

  /// Sets the meaning of a half-close for the next request on this connection.
  void expect(HalfClose half_close) { half_close_ = half_close; }
  /// Call before the work starts. The returned token is stopped when the client leaves, or by cancel().
  std::stop_token begin();
  /// Returns a token that is only stopped by cancel().
  std::stop_token cancelled() const { return cancel_.get_token(); }
  /// Checks again whether the work is done.
  void wake() { woken_.cancel(); }
  /// Cancels the current work and all later work.
  void cancel() {
    cancel_.request_stop();
    stop_.request_stop();
  }

  /// Waits until `done` returns true; it is called again after each wake(). A client that leaves also wakes
  /// the wait. `done` must outlive the wait and be a variable: g++ 12 destroys a temporary in the arguments
  /// of an awaited call twice.
  asio::awaitable<void> until(const std::function<bool()>& done);

  bool stopped() const { return stop_.stop_requested(); }
  /// Returns whether the client closed its side or reset the connection during the wait.
  bool client_left() const { return left_; }

 private:
  void watch();
  void look(error_code ec, bool reads);

  const std::shared_ptr<TimedSocket> connection_;
  beast::flat_buffer& ahead_;
  asio::steady_timer woken_;  // never expires; cancelled to wake the wait
  std::stop_source stop_, cancel_;
  HalfClose half_close_ = HalfClose::kIsGone;
  bool left_ = false, watching_ = false;
  bool armed_ = false;  // the socket has a watch, possibly one of the previous wait
};

}  // namespace fracture::http
