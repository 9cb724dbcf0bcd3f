// What a frame shows of the snapshots of a game: between two of them, by the time that passed.
//
// The playhead runs with the frames' time, but never beyond the newest snapshot: what is seen is as late as steps arrive late.
// Where the game keeps up, that is a step or two of frames; where a step takes several frames, it is the length of a step, and
// its motion is spread over them. It runs a little faster than time, so that a delay that is needed no more goes by itself.
#pragma once

#include <deque>
#include <utility>

#include "client/app/simulation.hpp"

namespace fracture::app {

class Playback {
 public:
  using Published = std::vector<std::shared_ptr<const Snapshot>>;
  /// At least one.
  explicit Playback(Published first) { add(std::move(first)); }
  void add(Published published);
  /// So much of the frames' time, in which the playhead moves on.
  void pass(double seconds, double step_length);

  /// What is known of the game.
  const Snapshot& latest() const { return *ahead_.back(); }
  /// What is seen of it.
  const game::Moment& moment() const { return shown_; }
  const effects::Debris& debris() const { return debris_; }
  /// Begin with what is seen now, since the last call.
  std::vector<sound::Voice> take_voices() { return std::exchange(voices_, {}); }
  /// Fragments that are not seen yet, but soon.
  std::vector<game::Game::Coming> coming() const;

  /// The playhead's speed.
  static constexpr double kSpeed = 1.02;

 private:
  void reach(const Snapshot& snapshot);

  std::deque<std::shared_ptr<const Snapshot>>
      ahead_;            // of the one that the playhead has passed, and those before it
  double playhead_ = 0;  // on the clock of Snapshot::due
  game::Moment shown_;
  effects::Debris debris_;
  std::vector<sound::Voice> voices_;
};

/// A game on its thread, and what frames see of it.
struct LiveGame {
  LiveGame(std::unique_ptr<game::Game> game, std::uint64_t debris_seed)
      : simulation(std::move(game), debris_seed), playback(simulation.take()) {}
  /// A frame that took so many seconds. Returns the notes that have come.
  std::vector<std::string> frame(const Tick& tick, double seconds);

  Simulation simulation;
  Playback playback;
};

}  // namespace fracture::app
