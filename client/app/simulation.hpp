// A game on its own thread, so that no frame waits for a step.
//
//   frame:       pass(time, eye) ── post(command) ── take() ──> snapshots to draw, one per step
//                     │                 │               ▲
//                     ▼                 ▼               │ one lock, held for a swap of vectors
//   simulation:  commands ── Game::attend ── [snapshot] ── Game::step ── snapshot
//
// The thread has no clock: it computes only as many steps as frames have given it time for. So the game
// stands still if the window draws nothing, and tests need not wait. Time beyond kMostOwed steps is dropped:
// a game that cannot keep up slows down instead of falling behind.
//
// Everything shared is immutable or protected by the lock. The Game belongs to the thread until halt() ends
// it.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "client/app/snapshot.hpp"

namespace fracture::app {

/// The message of a frame to its game.
struct Tick {
  double seconds = 0;  ///< since the previous frame, in game time: less in slow motion
  bool running = false;
  glm::dvec3 eye{0};
  bool loads = false;  ///< whether Moment::Part::loads are needed
};

class Simulation {
 public:
  /// A command that runs between two steps. A non-empty return value is a note for people.
  using Command = std::function<std::string(game::Game&)>;
  /// The maximum number of steps that may be owed.
  static constexpr int kMostOwed = 6;

  /// If the game has a recording to play (GameSettings::replay), the recording is played as fast as possible.
  /// Then the player takes over.
  Simulation(std::unique_ptr<game::Game> game, std::uint64_t debris_seed);
  ~Simulation();  ///< calls halt()
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Passes a frame. Neither this nor the next four functions wait for a step.
  void pass(const Tick& tick);
  /// Plays one step, whether the game is running or paused.
  void step_once();
  /// Runs before the next step, even while paused, in the order of posting. After halt(): at once.
  void post(Command command);
  /// The snapshots since the last call, in order. The first call includes the initial one. Each step and
  /// command adds a snapshot, and so does each frame while the game is paused.
  std::vector<std::shared_ptr<const Snapshot>> take();
  const scenes::Scene& scene() const { return game_->scene(); }
  double step_length() const { return step_length_; }

  /// Ends the thread, after the current step. Frames of a running game must not wait for a step, so call this
  /// only to end or rewind a game. Commands posted before are run before it returns; owed steps are not.
  void halt();
  /// Only after halt().
  const game::Game& game() const { return *game_; }

 private:
  struct Work {
    std::vector<Command> commands;
    glm::dvec3 eye{0};
    bool step = false;
  };
  void run(const std::stop_token& stop);
  void play_again(const std::stop_token& stop);
  std::optional<Work> next(const std::stop_token& stop);
  void carry_out(Work work);
  void step();
  void publish();
  bool asked_for();

  const std::unique_ptr<game::Game> game_;
  const double step_length_;

  // Used only by the thread.
  effects::Debris debris_;
  std::shared_ptr<const effects::Debris> shown_debris_;
  sound::Soundscape soundscape_;
  std::vector<sound::Voice> voices_;
  std::vector<std::string> notes_;
  world::Census census_;
  std::shared_ptr<const std::string> patterns_;
  double due_ = 0, step_ms_ = 0;
  unsigned published_count_ = 0;

  std::mutex mutex_;  // protects the following members
  std::condition_variable_any wake_;
  std::vector<Command> commands_;
  std::vector<std::shared_ptr<const Snapshot>> published_;
  Tick tick_;             // the last one
  bool visited_ = false;  // whether a frame came since the last snapshot or check
  bool playing_again_ = false;
  double owed_ = 0, dropped_ = 0;  // seconds still to be computed; seconds by which the next step is delayed
  int singles_ = 0;                // number of single steps that were requested

  bool halted_ = false;  // used only by the owner
  std::jthread thread_;  // last, because it uses the others
};

}  // namespace fracture::app
