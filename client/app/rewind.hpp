// Going back in the window's game: the past is shown while a key is held, and played again when it is released.
//
//   follow ── hold ── hold ──> shown()          pictures of the last ten seconds, without any physics
//                       └── release ── begin ── play_on ── play_on ──> the game as it was at that step
#pragma once

#include <memory>
#include <optional>

#include "client/app/playback.hpp"

namespace fracture::app {

class Rewind {
 public:
  using Moment = std::shared_ptr<const game::Moment>;

  /// A frame of a game that goes on.
  void follow(Moment now) { past_.add(std::move(now)); }
  /// The key is held for so many seconds more, in a game that is here now and has steps of that length.
  void hold(const Moment& now, double step_length, double seconds);
  bool held() const { return cursor_.has_value(); }
  /// What is seen meanwhile, and until the game is there; null: the game as it is.
  const game::Moment* shown() const { return shown_.get(); }
  double seconds_back() const { return seconds_back_; }
  /// The key is released: so many steps have to be played again.
  std::uint64_t release();

  /// Plays a game, which has GameSettings::replay, to the end of that.
  void begin(std::unique_ptr<LiveGame> again) { again_ = std::move(again); }
  const LiveGame* playing() const { return again_.get(); }
  int percent() const { return again_->playback.latest().played_again_percent.value_or(100); }
  struct Played {
    std::unique_ptr<LiveGame> game;           ///< handed over
    std::optional<std::uint64_t> diverged{};  ///< it is there, for it was another game from this step on
  };
  /// A frame that took so many seconds; nothing before the end.
  std::optional<Played> play_on(const Tick& tick, double seconds);
  /// Another game: its past is none of this one's. Returns what was being played, whose end takes a moment.
  std::unique_ptr<LiveGame> clear();

 private:
  game::Past past_;
  std::optional<double> cursor_;  ///< step
  Moment shown_;
  double seconds_back_ = 0;
  std::unique_ptr<LiveGame> again_;
};

}  // namespace fracture::app
