// How a connection waits for work that is done elsewhere, and learns that its client is gone.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include "server/http/problem.hpp"
#include "server/http/timed_socket.hpp"

namespace fracture::http {

/// What it means that a client closes its side of the connection while it waits.
enum class HalfClose {
  kIsGone,      ///< it takes its request back
  kStillReads,  ///< nothing: it has said that it would (Half-Close: yes)
};

/// What a client is told that has taken its request back and reads all the same.
Problem client_closed();

/// Used from the connection's strand only. Held by shared_ptr: the watch on the socket may outlive the wait.
///
/// An end of the stream is behind all that was sent before it. So what a client sends while it waits (pipelined
/// requests) is read, as far as the buffer has room. Behind more than that only a reset is seen: bytes that are not
/// read make every wait for an end of the stream return at once.
class WorkWait : public std::enable_shared_from_this<WorkWait> {
 public:
  /// `ahead` gets what is read meanwhile. It outlives every wait, and nothing else uses it during one.
  WorkWait(std::shared_ptr<TimedSocket> connection, beast::flat_buffer& ahead);

  /// Of the next request on this connection.
  void expect(HalfClose half_close) { half_close_ = half_close; }
  /// Before the work starts. The token is asked to stop when the client leaves, or by cancel().
  std::stop_token begin();
  /// Is asked to stop by cancel() alone.
  std::stop_token cancelled() const { return cancel_.get_token(); }
  /// Looks again whether what is waited for is there.
  void wake() { woken_.cancel(); }
  /// Also of all that begins later.
  void cancel() {
    cancel_.request_stop();
    stop_.request_stop();
  }

  /// Waits until `done`, which is asked again after each wake(). A client that leaves wakes, too. `done` outlives the
  /// wait and has a name: g++ 12 destroys a temporary twice that is an argument of what is awaited.
  asio::awaitable<void> until(const std::function<bool()>& done);

  bool stopped() const { return stop_.stop_requested(); }
  /// The client closed its side, or reset the connection, during the wait.
  bool client_left() const { return left_; }

 private:
  void watch();
  void look(error_code ec, bool reads);

  const std::shared_ptr<TimedSocket> connection_;
  beast::flat_buffer& ahead_;
  asio::steady_timer woken_;  // never expires: cancelled to wake
  std::stop_source stop_, cancel_;
  HalfClose half_close_ = HalfClose::kIsGone;
  bool left_ = false, watching_ = false;
  bool armed_ = false;  // the socket has a watch, perhaps of the wait before
};

}  // namespace fracture::http
