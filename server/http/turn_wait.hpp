// Lets a connection wait for its client's turn on the I/O threads.
#pragma once

#include <chrono>
#include <memory>

#include "server/http/asio.hpp"
#include "server/http/io_turns.hpp"

namespace fracture::http {

/// Use only from the connection's strand. Held by shared_ptr, because a turn may be granted after the
/// connection is gone. The socket is not watched: a client that closes its side may still want its answer.
class TurnWait : public std::enable_shared_from_this<TurnWait> {
 public:
  using Clock = std::chrono::steady_clock;

  /// `turns`: null if every request may begin at once.
  TurnWait(IoTurns* turns, const asio::any_io_executor& executor) : turns_(turns), woken_(executor) {}

  /// Returns whether the request may be handled at once. Otherwise call until_turn().
  bool at_once(const Flow& flow) { return !turns_ || turns_->begin(flow); }
  /// Returns true when the turn has come. It lasts until the coroutine waits for anything. Returns false, and
  /// leaves the queue, at `end` or after cancel(). `flow` must outlive the wait.
  asio::awaitable<bool> until_turn(const Flow& flow, Clock::time_point end);
  /// Ends this wait and all later ones.
  void cancel();

 private:
  IoTurns* const turns_;
  asio::steady_timer woken_;  // cancelled to wake the wait
  bool cancelled_ = false;
};

}  // namespace fracture::http
