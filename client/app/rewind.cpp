#include "client/app/rewind.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/app/sound_track.hpp"

namespace fracture::app {

void Rewind::hold(const game::Game& game, double seconds) {
  constexpr double kSpeed = 2;  // times that of the game: ten seconds back are five of holding a key
  const double step = game.world().settings().step;
  const auto now = static_cast<double>(game.world().steps());
  past_.add(game);
  cursor_ = std::max(0.0, cursor_.value_or(now) - kSpeed * seconds / step);
  const game::Moment* moment = past_.at(static_cast<std::uint64_t>(*cursor_));
  if (moment == nullptr) return;
  cursor_ = std::max(*cursor_, static_cast<double>(moment->step));
  if (!shown_ || shown_->step != moment->step) shown_ = *moment;
  seconds_back_ = step * (now - static_cast<double>(shown_->step));
}

std::uint64_t Rewind::release() {
  cursor_.reset();
  return shown_ ? shown_->step : 0;
}

void Rewind::begin(std::unique_ptr<game::Game> again, std::uint64_t debris_seed) {
  again_ = std::move(again);
  debris_ = effects::Debris(debris_seed);
}

int Rewind::percent() const {
  const std::shared_ptr<const game::Recording>& replay = again_->settings().replay;
  if (!replay || replay->hashes.empty()) return 100;
  return static_cast<int>(100 * again_->world().steps() / replay->hashes.size());
}

std::optional<Rewind::Played> Rewind::play_on() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kSlice(12);  // of a frame of 16
  const Clock::time_point begin = Clock::now();
  const std::optional<std::uint64_t>& diverged = again_->figures().diverged;
  while (!again_->replayed() && !diverged) {
    if (Clock::now() - begin > kSlice || !again_->ready()) return std::nullopt;
    again_->step();
    debris_.follow(again_->world(), again_->take_witnessed(), materials_of(*again_));
  }
  again_->hand_over();
  past_.clear();
  shown_.reset();
  Played played{std::move(again_), std::exchange(debris_, effects::Debris()), {}};
  played.diverged = played.game->figures().diverged;
  return played;
}

std::unique_ptr<game::Game> Rewind::clear() {
  past_.clear();
  cursor_.reset();
  shown_.reset();
  return std::move(again_);
}

}  // namespace fracture::app
