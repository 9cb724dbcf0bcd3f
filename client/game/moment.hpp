// Positions of everything after a step: enough to draw the game, now or in a rewind, without the game itself.
#pragma once

#include <deque>

#include "client/game/game.hpp"

namespace fracture::game {

struct Moment {
  struct Part {
    world::ObjectId id = 0;
    std::size_t scene_object = 0;                 ///< index into Scene::objects
    std::shared_ptr<const Decoded> broken;        ///< its fragments; null while it is whole
    world::Pose whole;                            ///< pose of the asset's frame, while it is whole
    std::vector<world::FragmentState> fragments;  ///< when it is broken
    std::vector<float> loads;                     ///< of its bonds (World::bond_states()), if requested
  };
  std::uint64_t step = 0;   ///< number of steps done
  std::vector<Part> parts;  ///< by number of the thing; things added later are missing
  std::vector<world::BallState> balls;
  std::size_t bytes() const;
};

Moment moment_of(const Game& game, bool loads = false);

/// Interpolates from `a` to `b` by `share` (0 … 1), along a line and about one axis. Anything that broke,
/// appeared or disappeared in between stays as it is in `a`. If a thing turns by the angle w between `a`
/// and `b`, the line deviates from the true circle by at most w²/8 of the thing's distance from its asset's
/// origin: by millimetres at three turns per second. If `into` is the previous result, its memory is reused.
void between(const Moment& a, const Moment& b, double share, Moment& into);

/// The last seconds of a game.
class Past {
 public:
  /// Beyond this many steps or bytes, the oldest moments are removed.
  explicit Past(std::uint64_t most_steps = 1200, std::size_t most_bytes = std::size_t{48} << 20)
      : most_steps_(most_steps), most_bytes_(most_bytes) {}
  /// Adds a moment of the running game, unless there was no step since the last one.
  void add(std::shared_ptr<const Moment> moment);
  void clear();
  /// The last moment at or before a step, else the oldest; null if there is none.
  std::shared_ptr<const Moment> at(std::uint64_t step) const;
  std::size_t size() const { return moments_.size(); }

 private:
  std::deque<std::shared_ptr<const Moment>> moments_;
  std::size_t bytes_ = 0;
  const std::uint64_t most_steps_;
  const std::size_t most_bytes_;
};

}  // namespace fracture::game
