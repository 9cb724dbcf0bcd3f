// A game on a thread of its own, so that no frame waits for a step.
//
//   frame:       pass(time, eye) ── post(command) ── take() ──> snapshots to draw, one for each step
//                     │                 │               ▲
//                     ▼                 ▼               │ one lock, held for a swap of vectors
//   simulation:  commands ── Game::attend ── [snapshot] ── Game::step ── snapshot
//
// The thread has no clock: it makes the steps for which frames have given it time, so that a window that draws nothing
// stands still, and tests need no patience. What it has not made of kMostOwed steps of time is dropped: a game that cannot keep
// up slows down instead of falling behind.
//
// All that is shared is immutable or behind the lock; the Game is the thread's alone, until halt() ends that.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "client/app/snapshot.hpp"

namespace fracture::app {

/// What a frame says to its game.
struct Tick {
  double seconds = 0;  ///< since the frame before, in the game's time: fewer in slow motion
  bool running = false;
  glm::dvec3 eye{0};
  bool loads = false;  ///< Moment::Part::loads are wanted
};

class Simulation {
 public:
  /// Something to do between two steps. What it returns, unless that is empty, is a note for people.
  using Command = std::function<std::string(game::Game&)>;
  /// The most that may be owed, in steps.
  static constexpr int kMostOwed = 6;

  /// Where the game has a recording to play (GameSettings::replay), it is played as fast as it goes, then handed over.
  Simulation(std::unique_ptr<game::Game> game, std::uint64_t debris_seed);
  ~Simulation();  ///< halt()
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// A frame. Never waits for a step; nor do the next four.
  void pass(const Tick& tick);
  /// One step, whether it runs or not.
  void step_once();
  /// Before the next step, also while paused; one after the other, in the order of posting. After halt(): at once.
  void post(Command command);
  /// Published since the last call, in order: at first one of the beginning. Later nothing, unless there was a step, a command or,
  /// while paused, a frame.
  std::vector<std::shared_ptr<const Snapshot>> take();
  const scenes::Scene& scene() const { return game_->scene(); }
  double step_length() const { return step_length_; }

  /// Ends the thread. Waits for the step that is at work, which no frame of a game that goes on does: for the end of a game, or to go
  /// back in it. What was posted before is done before it returns; what is owed is not.
  void halt();
  /// After halt().
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

  // The thread's own.
  effects::Debris debris_;
  std::shared_ptr<const effects::Debris> shown_debris_;
  sound::Soundscape soundscape_;
  std::vector<sound::Voice> voices_;
  std::vector<std::string> notes_;
  world::Census census_;
  std::shared_ptr<const std::string> patterns_;
  double due_ = 0, step_ms_ = 0;
  unsigned published_count_ = 0;

  std::mutex mutex_;  // of what follows
  std::condition_variable_any wake_;
  std::vector<Command> commands_;
  std::vector<std::shared_ptr<const Snapshot>> published_;
  Tick tick_;             // the last one
  bool visited_ = false;  // by a frame, since the last snapshot or the last look
  bool playing_again_ = false;
  double owed_ = 0, dropped_ = 0;  // seconds: to be made; that the next step is due later
  int singles_ = 0;                // steps that were asked for

  bool halted_ = false;  // the owner's
  std::jthread thread_;  // last: it uses the others
};

}  // namespace fracture::app
