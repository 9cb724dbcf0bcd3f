// Goes back in the window's game. While a key is held, past moments are shown. When it is released, the game
// is played again up to the chosen moment.
//
//   follow ── hold ── hold ──> shown()          moments of the last ten seconds, without physics
//                       └── release ── begin ── play_on ── play_on ──> the game as it was at that step
#pragma once

#include <memory>
#include <optional>

#include "client/app/playback.hpp"

namespace fracture::app {

class Rewind {
 public:
  using Moment = std::shared_ptr<const game::Moment>;

  /// Stores the moment of a frame while the game goes on.
  void follow(Moment now) { past_.add(std::move(now)); }
  /// Goes back while the key is held for these seconds. `now` is the game's current moment.
  void hold(const Moment& now, double step_length, double seconds);
  bool held() const { return cursor_.has_value(); }
  /// The moment to show until the replayed game is ready; null: show the game itself.
  const game::Moment* shown() const { return shown_.get(); }
  double seconds_back() const { return seconds_back_; }
  /// Call when the key is released. Returns the number of steps to play again.
  std::uint64_t release();

  /// Starts to replay a game that has GameSettings::replay.
  void begin(std::unique_ptr<LiveGame> again) { again_ = std::move(again); }
  const LiveGame* playing() const { return again_.get(); }
  int percent() const { return again_->playback.latest().played_again_percent.value_or(100); }
  struct Played {
    std::unique_ptr<LiveGame> game;           ///< the game, handed over
    std::optional<std::uint64_t> diverged{};  ///< the step from which the replay differed, which ended it
  };
  /// Runs a frame that took this many seconds. Returns the game once its replay has ended.
  std::optional<Played> play_on(const Tick& tick, double seconds);
  /// Forgets the past, for another game. Returns the game that was being replayed, because ending it takes a
  /// moment.
  std::unique_ptr<LiveGame> clear();

 private:
  game::Past past_;
  std::optional<double> cursor_;  ///< step
  Moment shown_;
  double seconds_back_ = 0;
  std::unique_ptr<LiveGame> again_;
};

}  // namespace fracture::app
