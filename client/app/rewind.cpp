#include "client/app/rewind.hpp"

#include <algorithm>
#include <utility>

namespace fracture::app {

void Rewind::hold(const Moment& now, double step_length, double seconds) {
  constexpr double kSpeed = 2;  // relative to the game's: holding the key for five seconds goes back ten
  const auto steps = static_cast<double>(now->step);
  past_.add(now);
  cursor_ = std::max(0.0, cursor_.value_or(steps) - kSpeed * seconds / step_length);
  Moment moment = past_.at(static_cast<std::uint64_t>(*cursor_));
  if (!moment) return;
  cursor_ = std::max(*cursor_, static_cast<double>(moment->step));
  shown_ = std::move(moment);
  seconds_back_ = step_length * (steps - static_cast<double>(shown_->step));
}

std::uint64_t Rewind::release() {
  cursor_.reset();
  return shown_ ? shown_->step : 0;
}

std::optional<Rewind::Played> Rewind::play_on(const Tick& tick, double seconds) {
  again_->frame(tick, seconds);
  const Snapshot& now = again_->playback.latest();
  if (now.played_again_percent) return std::nullopt;
  past_.clear();
  shown_.reset();
  return Played{std::move(again_), now.figures.diverged};
}

std::unique_ptr<LiveGame> Rewind::clear() {
  past_.clear();
  cursor_.reset();
  shown_.reset();
  return std::move(again_);
}

}  // namespace fracture::app
