#include "client/game/moment.hpp"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

namespace fracture::game {
namespace {

world::Pose between(const world::Pose& a, const world::Pose& b, double share) {
  // Most things are at rest.
  if (a.position == b.position && a.rotation == b.rotation) return a;
  return {glm::mix(a.position, b.position, share), glm::slerp(a.rotation, b.rotation, share)};
}

}  // namespace

std::size_t Moment::bytes() const {
  std::size_t sum = sizeof(Moment) + balls.size() * sizeof(world::BallState) + parts.size() * sizeof(Part);
  for (const Part& part : parts)
    sum += part.fragments.size() * sizeof(world::FragmentState) + part.loads.size() * sizeof(float);
  return sum;
}

Moment moment_of(const Game& game, bool loads) {
  Moment moment;
  moment.step = game.world().steps();
  moment.balls = game.world().balls();
  moment.parts.reserve(game.things().size());
  for (const Thing& thing : game.things()) {
    Moment::Part& part = moment.parts.emplace_back();
    part.id = thing.id;
    part.scene_object = thing.scene_object;
    part.broken = thing.fragments;
    if (!part.broken) {
      part.whole = game.world().object_pose(thing.id);
      continue;
    }
    game.world().fragment_states(thing.id, part.fragments);
    if (loads) part.loads = game.world().bond_states(thing.id);
  }
  return moment;
}

void between(const Moment& a, const Moment& b, double share, Moment& into) {
  into.step = a.step;
  into.parts.resize(a.parts.size());
  for (std::size_t k = 0; k < a.parts.size(); ++k) {
    Moment::Part& part = into.parts[k];
    part = a.parts[k];
    if (k >= b.parts.size() || b.parts[k].broken != part.broken) continue;
    const Moment::Part& next = b.parts[k];
    part.whole = between(part.whole, next.whole, share);
    const std::size_t count = std::min(part.fragments.size(), next.fragments.size());
    for (std::size_t f = 0; f < count; ++f) {
      world::FragmentState& state = part.fragments[f];
      const world::FragmentState& then = next.fragments[f];
      if (!state.present || !then.present) continue;
      state.asset_to_world = between(state.asset_to_world, then.asset_to_world, share);
      state.size += static_cast<float>(share) * (then.size - state.size);
    }
  }
  into.balls = a.balls;
  for (world::BallState& ball : into.balls) {
    const auto then = std::find_if(b.balls.begin(), b.balls.end(),
                                   [&](const world::BallState& other) { return other.id == ball.id; });
    if (then != b.balls.end()) ball.pose = between(ball.pose, then->pose, share);
  }
}

void Past::add(std::shared_ptr<const Moment> moment) {
  if (!moments_.empty() && moments_.back()->step >= moment->step) return;
  bytes_ += moment->bytes();
  moments_.push_back(std::move(moment));
  while (moments_.size() > 1 &&
         (bytes_ > most_bytes_ || moments_.front()->step + most_steps_ < moments_.back()->step)) {
    bytes_ -= moments_.front()->bytes();
    moments_.pop_front();
  }
}

void Past::clear() {
  moments_.clear();
  bytes_ = 0;
}

std::shared_ptr<const Moment> Past::at(std::uint64_t step) const {
  std::shared_ptr<const Moment> found = moments_.empty() ? nullptr : moments_.front();
  for (const std::shared_ptr<const Moment>& moment : moments_)
    if (moment->step <= step) found = moment;
  return found;
}

}  // namespace fracture::game
