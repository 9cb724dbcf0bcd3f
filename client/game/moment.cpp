#include "client/game/moment.hpp"

namespace fracture::game {

std::size_t Moment::bytes() const {
  std::size_t sum = sizeof(Moment) + balls.size() * sizeof(world::BallState) + parts.size() * sizeof(Part);
  for (const Part& part : parts) sum += part.fragments.size() * sizeof(world::FragmentState);
  return sum;
}

Moment moment_of(const Game& game) {
  Moment moment;
  moment.step = game.world().steps();
  moment.balls = game.world().balls();
  for (const Thing& thing : game.things()) {
    Moment::Part& part = moment.parts.emplace_back();
    part.broken = thing.fragments;
    if (part.broken)
      game.world().fragment_states(thing.id, part.fragments);
    else
      part.whole = game.world().object_pose(thing.id);
  }
  return moment;
}

void Past::add(const Game& game) {
  if (!moments_.empty() && moments_.back().step >= game.world().steps()) return;
  moments_.push_back(moment_of(game));
  bytes_ += moments_.back().bytes();
  while (moments_.size() > 1 &&
         (bytes_ > most_bytes_ || moments_.front().step + most_steps_ < moments_.back().step)) {
    bytes_ -= moments_.front().bytes();
    moments_.pop_front();
  }
}

void Past::clear() {
  moments_.clear();
  bytes_ = 0;
}

const Moment* Past::at(std::uint64_t step) const {
  const Moment* found = moments_.empty() ? nullptr : &moments_.front();
  for (const Moment& moment : moments_)
    if (moment.step <= step) found = &moment;
  return found;
}

}  // namespace fracture::game
