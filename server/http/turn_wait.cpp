#include "server/http/turn_wait.hpp"

#include <functional>
#include <utility>

namespace fracture::http {

asio::awaitable<bool> TurnWait::until_turn(const Flow& flow, Clock::time_point end) {
  woken_.expires_at(end);
  // A variable: g++ 12 destroys a temporary in a coroutine's call twice.
  std::function<void()> wake = [weak = weak_from_this(), executor = woken_.get_executor()] {
    asio::dispatch(executor, [weak] {
      if (const auto self = weak.lock()) self->woken_.cancel();
    });
  };
  IoTurns::Place place = turns_->wait(flow, std::move(wake));
  while (!place.granted() && !cancelled_ && Clock::now() < end) {
    error_code ignored;
    co_await woken_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  }
  co_return !cancelled_ && place.take();
}

void TurnWait::cancel() {
  cancelled_ = true;
  woken_.cancel();
}

}  // namespace fracture::http
