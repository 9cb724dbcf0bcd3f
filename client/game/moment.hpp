// Where everything is at the end of a step: what is drawn of a game, now and in a rewind, without the game itself.
#pragma once

#include <deque>

#include "client/game/game.hpp"

namespace fracture::game {

struct Moment {
  struct Part {
    world::ObjectId id = 0;
    std::size_t scene_object = 0;                 ///< index into Scene::objects
    std::shared_ptr<const Decoded> broken;        ///< into what; null while it is whole
    world::Pose whole;                            ///< of the asset's frame, while it is whole
    std::vector<world::FragmentState> fragments;  ///< when it is broken
    std::vector<float> loads;                     ///< of its bonds, as World::bond_states(), where asked for
  };
  std::uint64_t step = 0;   ///< so many were done
  std::vector<Part> parts;  ///< by number of the thing; things that came later have none
  std::vector<world::BallState> balls;
  std::size_t bytes() const;
};

Moment moment_of(const Game& game, bool loads = false);

/// What of `a` has moved a share (0 … 1) of its way to where it is in `b`: along a line, turning about one axis. What is not
/// the same in both (it broke, came or went) stays as it is in `a`. Something that turns by an angle w in between comes off its
/// circle by at most w²/8 of its distance from the origin of its asset: millimetres for what turns three times a second.
/// `into` may be what it was of the moment before: its memory is used again.
void between(const Moment& a, const Moment& b, double share, Moment& into);

/// The last seconds of a game.
class Past {
 public:
  /// The oldest go where there are more steps or bytes than that.
  explicit Past(std::uint64_t most_steps = 1200, std::size_t most_bytes = std::size_t{48} << 20)
      : most_steps_(most_steps), most_bytes_(most_bytes) {}
  /// Of a game that goes on: nothing where there was no step since the last moment.
  void add(std::shared_ptr<const Moment> moment);
  void clear();
  /// The last moment at a step or before it, or the oldest; null where there is none.
  std::shared_ptr<const Moment> at(std::uint64_t step) const;
  std::size_t size() const { return moments_.size(); }

 private:
  std::deque<std::shared_ptr<const Moment>> moments_;
  std::size_t bytes_ = 0;
  const std::uint64_t most_steps_;
  const std::size_t most_bytes_;
};

}  // namespace fracture::game
