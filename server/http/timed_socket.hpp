// A socket whose operations end at a deadline.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "server/http/asio.hpp"

namespace fracture::http {

/// Used from the socket's strand only. Held by shared_ptr: the timer's handler may run after its owner has
/// gone.
class TimedSocket : public std::enable_shared_from_this<TimedSocket> {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TimedSocket(tcp::socket socket);

  tcp::socket& socket() { return socket_; }

  /// From now on every operation ends at `when`, with timed_out(). A later call replaces it.
  void set_deadline(Clock::time_point when);
  void clear_deadline();
  bool timed_out() const { return timed_out_; }

  /// No operation goes on beyond this, whatever deadline is set from now on.
  void end_by(Clock::time_point when);

  /// Ends every operation in progress.
  void abort();
  /// Bytes that the kernel holds because the client has not taken them.
  std::uint64_t unsent();
  /// The connection was reset; urgent data, which wakes the same wait, is none.
  bool is_reset();
  /// Takes what the client has sent into the buffer, which must have room. False: the client has closed its side, or
  /// the connection was reset.
  bool read_ahead(beast::flat_buffer& buffer);
  /// Takes a byte of urgent data, which no request has a use for. False where there is none.
  bool take_urgent_byte();
  /// After an answer that ends the connection, what the client still sends is read and thrown away for a
  /// while: closing a socket with unread data makes the kernel send a reset that can destroy the answer
  /// before the client has read it.
  asio::awaitable<void> linger();

 private:
  tcp::socket socket_;
  asio::steady_timer timer_;
  Clock::time_point end_ = Clock::time_point::max();
  std::uint64_t generation_ = 0;
  bool timed_out_ = false;
};

}  // namespace fracture::http
