#include "server/http/work_wait.hpp"

#include <utility>

namespace fracture::http {

WorkWait::WorkWait(std::shared_ptr<TimedSocket> connection)
    : connection_(std::move(connection)), woken_(connection_->socket().get_executor()) {}

std::stop_token WorkWait::begin() {
  stop_ = std::stop_source();
  if (cancelled_) stop_.request_stop();
  reset_ = false;
  woken_.expires_at(asio::steady_timer::time_point::max());
  return stop_.get_token();
}

asio::awaitable<void> WorkWait::until(const std::function<bool()>& done) {
  if (done()) co_return;
  watching_ = true;
  watch_for_reset();
  do {
    error_code ignored;
    co_await woken_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  } while (!done());
  watching_ = false;
  connection_->abort();  // ends the watch
}

void WorkWait::watch_for_reset() {
  connection_->socket().async_wait(tcp::socket::wait_error, [weak = weak_from_this()](error_code ec) {
    const auto self = weak.lock();
    if (ec || !self) return;
    if (!self->connection_->is_reset()) {
      // While an urgent byte waits to be taken, a new watch ends at once.
      if (self->watching_ && self->connection_->take_urgent_byte()) self->watch_for_reset();
      return;
    }
    self->reset_ = true;
    self->stop_.request_stop();
    self->wake();
  });
}

}  // namespace fracture::http
