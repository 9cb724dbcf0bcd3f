// Going back in the window's game: the past is shown while a key is held, and played again when it is released.
//
//   follow ── hold ── hold ──> shown()          pictures of the last ten seconds, without any physics
//                       └── release ── begin ── play_on ── play_on ──> the game as it was at that step
#pragma once

#include <memory>
#include <optional>

#include "client/effects/debris.hpp"
#include "client/game/moment.hpp"

namespace fracture::app {

class Rewind {
 public:
  /// A frame of a game that goes on.
  void follow(const game::Game& game) { past_.add(game); }
  /// The key is held for so many seconds more.
  void hold(const game::Game& game, double seconds);
  bool held() const { return cursor_.has_value(); }
  /// What is seen meanwhile, and until the game is there; null: the game as it is.
  const game::Moment* shown() const { return shown_ ? &*shown_ : nullptr; }
  double seconds_back() const { return seconds_back_; }
  /// The key is released: so many steps have to be played again.
  std::uint64_t release();

  /// Plays a game, which has GameSettings::replay, to the end of that.
  void begin(std::unique_ptr<game::Game> again, std::uint64_t debris_seed);
  const game::Game* playing() const { return again_.get(); }
  int percent() const;
  struct Played {
    std::unique_ptr<game::Game> game;         ///< handed over
    effects::Debris debris;                   ///< marks and crumbs as they lay then
    std::optional<std::uint64_t> diverged{};  ///< it is there, for it was another game from this step on
  };
  /// For some milliseconds, so that the window stays alive; nothing before the end.
  std::optional<Played> play_on();
  /// Another game: its past is none of this one's. Returns what was being played, whose end takes a moment.
  std::unique_ptr<game::Game> clear();

 private:
  game::Past past_;
  std::optional<double> cursor_;  ///< step
  std::optional<game::Moment> shown_;
  double seconds_back_ = 0;
  std::unique_ptr<game::Game> again_;
  effects::Debris debris_;
};

}  // namespace fracture::app
