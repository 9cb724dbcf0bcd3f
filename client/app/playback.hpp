// Interpolates frames between two snapshots of a game, by the time that has passed.
//
// The playhead follows the frames' time, but never passes the newest snapshot. So the picture is as late as
// the steps are. If the game keeps up, that is one or two steps. If a step takes several frames, it is the
// length of a step, and the motion is spread over these frames. The playhead runs slightly faster than time.
// So it catches up when steps become faster.
#pragma once

#include <deque>
#include <utility>

#include "client/app/simulation.hpp"

namespace fracture::app {

class Playback {
 public:
  using Published = std::vector<std::shared_ptr<const Snapshot>>;
  /// `first` holds at least one snapshot.
  explicit Playback(Published first) { add(std::move(first)); }
  void add(Published published);
  /// Advances the playhead by the time of a frame.
  void pass(double seconds, double step_length);

  /// The newest known state of the game.
  const Snapshot& latest() const { return *ahead_.back(); }
  /// The state that is shown.
  const game::Moment& moment() const { return shown_; }
  const effects::Debris& debris() const { return debris_; }
  /// The voices that began in the shown state since the last call.
  std::vector<sound::Voice> take_voices() { return std::exchange(voices_, {}); }
  /// Fragments that will be shown soon.
  std::vector<game::Game::Coming> coming() const;

  /// The playhead's speed, relative to the frames' time.
  static constexpr double kSpeed = 1.02;

 private:
  void reach(const Snapshot& snapshot);

  // The last snapshot that the playhead has passed, and later ones
  std::deque<std::shared_ptr<const Snapshot>> ahead_;
  double playhead_ = 0;  // on the clock of Snapshot::due
  game::Moment shown_;
  effects::Debris debris_;
  std::vector<sound::Voice> voices_;
};

/// A game on its thread, with the playback that frames show.
struct LiveGame {
  LiveGame(std::unique_ptr<game::Game> game, std::uint64_t debris_seed)
      : simulation(std::move(game), debris_seed), playback(simulation.take()) {}
  /// Runs a frame that took this many seconds. Returns the new notes.
  std::vector<std::string> frame(const Tick& tick, double seconds);

  Simulation simulation;
  Playback playback;
};

}  // namespace fracture::app
