// Where everything was at the end of a step: what a rewind shows before the game is there again.
#pragma once

#include <deque>

#include "client/game/game.hpp"

namespace fracture::game {

struct Moment {
  struct Part {
    std::shared_ptr<const Decoded> broken;        ///< into what; null while it is whole
    world::Pose whole;                            ///< of the asset's frame, while it is whole
    std::vector<world::FragmentState> fragments;  ///< when it is broken
  };
  std::uint64_t step = 0;   ///< so many were done
  std::vector<Part> parts;  ///< by number of the thing; things that came later have none
  std::vector<world::BallState> balls;
  std::size_t bytes() const;
};

Moment moment_of(const Game& game);

/// The last seconds of a game.
class Past {
 public:
  /// The oldest go where there are more steps or bytes than that.
  explicit Past(std::uint64_t most_steps = 1200, std::size_t most_bytes = std::size_t{48} << 20)
      : most_steps_(most_steps), most_bytes_(most_bytes) {}
  /// Of a game that goes on: nothing where there was no step since the last moment.
  void add(const Game& game);
  void clear();
  /// The last moment at a step or before it, or the oldest; null where there is none.
  const Moment* at(std::uint64_t step) const;
  std::size_t size() const { return moments_.size(); }

 private:
  std::deque<Moment> moments_;
  std::size_t bytes_ = 0;
  const std::uint64_t most_steps_;
  const std::size_t most_bytes_;
};

}  // namespace fracture::game
