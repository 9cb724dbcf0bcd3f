// A socket whose operations have deadlines.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "server/http/asio.hpp"

namespace fracture::http {

/// Use only from the socket's strand. Held by shared_ptr, because the timer's handler may run after the owner
/// is gone.
class TimedSocket : public std::enable_shared_from_this<TimedSocket> {
 public:
  using Clock = std::chrono::steady_clock;

  explicit TimedSocket(tcp::socket socket);

  tcp::socket& socket() { return socket_; }

  /// Ends every operation at `when`; timed_out() is then true. A later call replaces the deadline.
  void set_deadline(Clock::time_point when);
  void clear_deadline();
  bool timed_out() const { return timed_out_; }

  /// Sets a final end for all operations, whatever deadlines are set later.
  void end_by(Clock::time_point when);

  /// Ends every operation in progress.
  void abort();
  /// Returns the number of bytes in the kernel that the client has not taken yet.
  std::uint64_t unsent();
  /// Returns whether the connection was reset. Urgent data, which ends the same wait, does not count.
  bool is_reset();
  /// Reads data that the client has sent into the buffer, which must have room. Returns false if the client
  /// has closed its side or the connection was reset.
  bool read_ahead(beast::flat_buffer& buffer);
  /// Reads and drops one byte of urgent data, which no request uses. Returns false if there is none.
  bool take_urgent_byte();
  /// Reads and drops data from the client for a short time after the last answer. If a socket is closed with
  /// unread data, the kernel sends a reset, which can destroy the answer before the client has read it.
  asio::awaitable<void> linger();

 private:
  tcp::socket socket_;
  asio::steady_timer timer_;
  Clock::time_point end_ = Clock::time_point::max();
  std::uint64_t generation_ = 0;
  bool timed_out_ = false;
};

}  // namespace fracture::http
