#include "client/app/playback.hpp"

#include <algorithm>

namespace fracture::app {

void Playback::add(Published published) {
  if (ahead_.empty() && !published.empty()) {
    playhead_ = published.front()->due;
    reach(*published.front());
    shown_ = *published.front()->moment;
    debris_ = *published.front()->debris;
  }
  for (std::shared_ptr<const Snapshot>& snapshot : published) ahead_.push_back(std::move(snapshot));
}

void Playback::reach(const Snapshot& snapshot) {
  voices_.insert(voices_.end(), snapshot.voices.begin(), snapshot.voices.end());
}

void Playback::pass(double seconds, double step_length) {
  playhead_ = std::min(playhead_ + kSpeed * seconds, ahead_.back()->due);
  while (ahead_.size() > 1 && ahead_[1]->due <= playhead_) {
    ahead_.pop_front();
    reach(*ahead_.front());
  }
  const Snapshot& from = *ahead_.front();
  debris_ = *from.debris;
  if (ahead_.size() == 1 || playhead_ <= from.due) {
    shown_ = *from.moment;
    return;
  }
  const Snapshot& to = *ahead_[1];
  const double share = (playhead_ - from.due) / (to.due - from.due);
  game::between(*from.moment, *to.moment, share, shown_);
  const auto steps = static_cast<double>(to.moment->step - from.moment->step);
  debris_.move(static_cast<float>(share * steps * step_length));
}

std::vector<game::Game::Coming> Playback::coming() const {
  std::vector<game::Game::Coming> list = ahead_.back()->coming;
  const std::vector<game::Moment::Part>& seen = ahead_.front()->moment->parts;
  for (std::size_t n = 1; n < ahead_.size(); ++n) {
    const std::vector<game::Moment::Part>& parts = ahead_[n]->moment->parts;
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (parts[k].broken && (k >= seen.size() || seen[k].broken != parts[k].broken))
        list.push_back({k, parts[k].scene_object, parts[k].broken});
  }
  return list;
}

std::vector<std::string> LiveGame::frame(const Tick& tick, double seconds) {
  simulation.pass(tick);
  Playback::Published published = simulation.take();
  std::vector<std::string> notes;
  for (const std::shared_ptr<const Snapshot>& snapshot : published)
    notes.insert(notes.end(), snapshot->notes.begin(), snapshot->notes.end());
  playback.add(std::move(published));
  // While the game is paused, the remaining snapshots are still played.
  playback.pass(tick.running ? tick.seconds : seconds, simulation.step_length());
  return notes;
}

}  // namespace fracture::app
