#include "server/http/work_wait.hpp"

#include <utility>

namespace fracture::http {

Problem client_closed() {
  return Problem(
      HttpProblem::kClientClosed,
      "The client closed its side of the connection while it was waiting for the answer. A client that "
      "closes only its sending side must send 'Half-Close: yes'.");
}

WorkWait::WorkWait(std::shared_ptr<TimedSocket> connection, beast::flat_buffer& ahead)
    : connection_(std::move(connection)), ahead_(ahead), woken_(connection_->socket().get_executor()) {}

std::stop_token WorkWait::begin() {
  stop_ = std::stop_source();
  if (cancel_.stop_requested()) stop_.request_stop();
  left_ = false;
  woken_.expires_at(asio::steady_timer::time_point::max());
  return stop_.get_token();
}

asio::awaitable<void> WorkWait::until(const std::function<bool()>& done) {
  if (done()) co_return;
  watching_ = true;
  watch();
  do {
    error_code ignored;
    co_await woken_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  } while (!done());
  watching_ = false;
  connection_->abort();  // ends the watch
}

void WorkWait::watch() {
  if (std::exchange(armed_, true)) return;
  const bool reads = half_close_ == HalfClose::kIsGone && ahead_.size() < ahead_.max_size();
  connection_->socket().async_wait(reads ? tcp::socket::wait_read : tcp::socket::wait_error,
                                   [weak = weak_from_this(), reads](error_code ec) {
                                     const auto self = weak.lock();
                                     if (!self) return;
                                     self->armed_ = false;
                                     if (self->watching_) self->look(ec, reads);
                                   });
}

void WorkWait::look(error_code ec, bool reads) {
  if (ec == asio::error::operation_aborted) return watch();  // it belonged to the previous wait
  if (ec) return;
  if (reads ? connection_->read_ahead(ahead_) : !connection_->is_reset()) {
    // An urgent byte must be read first. Otherwise a new wait for errors would end at once.
    if (reads || connection_->take_urgent_byte()) watch();
    return;
  }
  left_ = true;
  stop_.request_stop();
  wake();
}

}  // namespace fracture::http
