// Replays a game: recorded events happen at the steps at which they were recorded.
#include <algorithm>

#include "client/game/game.hpp"

namespace fracture::game {

void Game::play_recorded() {
  const std::vector<RecordedEvent>& events = settings_.replay->events;
  for (; next_recorded_ < events.size() && events[next_recorded_].step <= world_.steps(); ++next_recorded_) {
    const RecordedEvent& event = events[next_recorded_];
    switch (event.kind) {
      case RecordedEvent::Kind::kThrow:
        throw_ball(event.from, event.velocity, {event.radius, event.density});
        break;
      case RecordedEvent::Kind::kExplode:
        explode({event.from, event.impulse, event.radius});
        break;
      case RecordedEvent::Kind::kOverrides:
        set_overrides(event.overrides);
        break;
      case RecordedEvent::Kind::kEye:
        eye_ = event.from;
        break;
      case RecordedEvent::Kind::kMass:
        if (event.thing < things_.size()) scale_mass(event.thing, event.factor);
        break;
      case RecordedEvent::Kind::kAdopt:
      case RecordedEvent::Kind::kFail:
        play_answer(event);
        break;
    }
  }
}

void Game::play_answer(const RecordedEvent& event) {
  const auto it = pending_.find(event.request);
  const bool failed = event.kind == RecordedEvent::Kind::kFail;
  if (it == pending_.end() || (it->second.failed && !failed)) {
    if (!figures_.diverged) figures_.diverged = world_.steps();
    if (it == pending_.end()) return;
  }
  if (failed) {
    // The request failed in the recording, whatever the server answers now.
    client_.cancel(it->second.ticket);
    it->second.failed = true;
  }
  adopt(it);
  ask_most_urgent();
}

/// Whether the answers that the next events need have arrived.
bool Game::replay_is_ready() const {
  const std::vector<RecordedEvent>& events = settings_.replay->events;
  for (std::size_t k = next_recorded_; k < events.size() && events[k].step <= world_.steps(); ++k) {
    if (events[k].kind != RecordedEvent::Kind::kAdopt) continue;
    const auto it = pending_.find(events[k].request);
    if (it != pending_.end() && !it->second.finished()) return false;
  }
  return true;
}

void Game::hand_over() {
  if (!settings_.replay) return;
  settings_.replay = nullptr;
  owed_ = 0;
  for (const auto& [things, answer] : std::exchange(to_weigh_, {})) weigh(things, answer);
  // Throws and explosions due before the next step have already happened, or were left out.
  const double next = static_cast<double>(world_.steps()) * settings_.world.step;
  constexpr double kSameTime = 1e-9;  // seconds
  const double last = next - settings_.world.step + kSameTime;
  while (next_throw_ < scene_.throws.size() && scene_.throws[next_throw_].time < last) ++next_throw_;
  while (next_blast_ < scene_.blasts.size() && scene_.blasts[next_blast_].time < last) ++next_blast_;
}

}  // namespace fracture::game
