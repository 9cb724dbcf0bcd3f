#include "server/http/timed_socket.hpp"

#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "server/http/limits.hpp"

namespace fracture::http {
namespace {

constexpr std::chrono::seconds kLingerIdle{2}, kLingerTotal{10};

}  // namespace

TimedSocket::TimedSocket(tcp::socket socket) : socket_(std::move(socket)), timer_(socket_.get_executor()) {
  error_code ignored;
  socket_.set_option(tcp::no_delay(true), ignored);
  ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kMaxUnsent, sizeof kMaxUnsent);
}

void TimedSocket::set_deadline(Clock::time_point when) {
  const std::uint64_t generation = ++generation_;
  timed_out_ = false;
  timer_.expires_at(std::min(when, end_));
  timer_.async_wait([weak = weak_from_this(), generation](error_code ec) {
    const auto self = weak.lock();
    if (ec || !self || generation != self->generation_) return;
    self->timed_out_ = true;
    self->abort();
  });
}

void TimedSocket::clear_deadline() {
  if (end_ != Clock::time_point::max()) return set_deadline(end_);
  ++generation_;
  timer_.cancel();
}

void TimedSocket::end_by(Clock::time_point when) {
  end_ = when;
  set_deadline(when);
}

void TimedSocket::abort() {
  error_code ignored;
  socket_.cancel(ignored);
}

std::uint64_t TimedSocket::unsent() {
  int bytes = 0;
  return ::ioctl(socket_.native_handle(), SIOCOUTQ, &bytes) == 0 && bytes > 0
             ? static_cast<std::uint64_t>(bytes)
             : 0;
}

bool TimedSocket::is_reset() {
  int error = 0;
  socklen_t size = sizeof error;
  return ::getsockopt(socket_.native_handle(), SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error != 0;
}

bool TimedSocket::read_ahead(beast::flat_buffer& buffer) {
  constexpr std::size_t kAtOnce = 16u << 10;  // small enough for other connections to get their turn
  const auto room = buffer.prepare(std::min(kAtOnce, buffer.max_size() - buffer.size()));
  const ssize_t n = ::recv(socket_.native_handle(), room.data(), room.size(), MSG_DONTWAIT);
  if (n > 0) buffer.commit(static_cast<std::size_t>(n));
  return n > 0 || (n < 0 && (errno == EAGAIN || errno == EINTR));
}

bool TimedSocket::take_urgent_byte() {
  char byte = 0;
  return ::recv(socket_.native_handle(), &byte, 1, MSG_OOB | MSG_DONTWAIT) == 1;
}

asio::awaitable<void> TimedSocket::linger() {
  error_code ec;
  socket_.shutdown(tcp::socket::shutdown_send, ec);
  const Clock::time_point end = Clock::now() + kLingerTotal;
  std::array<char, 4096> rubbish;
  while (!ec) {
    set_deadline(std::min(end, Clock::now() + kLingerIdle));
    co_await socket_.async_read_some(asio::buffer(rubbish), asio::redirect_error(asio::use_awaitable, ec));
    if (Clock::now() >= end) break;
  }
  clear_deadline();
  socket_.close(ec);
}

}  // namespace fracture::http
