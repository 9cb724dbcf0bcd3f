// One game on two machines: each plays it by itself, from the same beginning and what both players do. No geometry is sent.
//
// Lines of JSON, as in a recording (recording.hpp). First the header of the game, from both, which has to be the same:
//
//   {"format": "fracture-lockstep-1", "rules": 3, "answer_steps": 6, "delay": 12, "scene": …, "seed": …, "digest": …}
//   {"step": 48, "throw": …}       what this player does takes effect so many steps later (`delay`), on both machines
//   {"step": 35, "hash": "90ab…"}  after each step. It also says that all is sent that this player does before
//                                  step 36 + delay: the other one may go on so far, and no further
//   {"refused": "…"}               there is no game, and why; the last line
//
// So nobody is more than `delay` steps ahead, what both do at one step happens in one order (who invited comes first), and
// the first step that is not the same on both is known at once. The game is a reproducible one
// (GameSettings::fixed_latency), seen from the scene's eye, whoever looks at it from where.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "client/game/game.hpp"
#include "client/game/peer_link.hpp"

namespace fracture::game {

inline constexpr unsigned kLockstepDelay = 12;  ///< steps: a tenth of a second

/// With what lockstep adds to the header of a recording.
nlohmann::json lockstep_header(nlohmann::json header, unsigned answer_steps, unsigned delay = kLockstepDelay);
/// kBadJson where it is no header of this version's lockstep; kUnavailable where it is a refusal.
Expected<nlohmann::json> read_lockstep_header(const std::string& line);

class Lockstep {
 public:
  enum class Seat { kHost, kGuest };
  /// `game` has been made as the header says, and outlives this, as does the link. `theirs`: the other's header, where it
  /// has been read already; else null.
  /// `patience`: for one who is there, but does not go on; more than a client waits for its server.
  Lockstep(Game& game, PeerLink& link, Seat seat, nlohmann::json header, nlohmann::json theirs = nullptr,
           std::chrono::milliseconds patience = std::chrono::seconds(90));

  void throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, const scenes::Ball& ball = {});
  void explode(const world::Blast& blast);

  /// May the next step be played? Polls; never waits.
  bool ready();
  /// Only when ready().
  void step();
  /// The other one has played every step that this one has, to the same bits. Polls.
  bool level();
  /// Ends the game, and tells the other player why.
  void leave(const std::string& why);
  /// Why the game is over; for people.
  const std::optional<std::string>& trouble() const { return trouble_; }
  /// The first step that was not the same on both.
  const std::optional<std::uint64_t>& diverged() const { return diverged_; }

 private:
  using Clock = std::chrono::steady_clock;
  void add(RecordedEvent event);
  void poll();
  void take(const std::string& line);
  void take_header(const nlohmann::json& theirs);
  void compare();
  void end(const std::string& why) {
    if (!trouble_) trouble_ = why;
  }
  void wait_on();
  bool may_play() const { return met_ && game_.world().steps() < heard_ + delay_; }

  Game& game_;
  PeerLink& link_;
  const Seat seat_;
  const nlohmann::json header_;
  const unsigned delay_;
  const std::chrono::milliseconds patience_;
  bool met_ = false;                              ///< the other's header was this one's
  std::uint64_t heard_ = 0;                       ///< so many steps the other has played
  std::optional<Clock::time_point> waits_since_;  ///< for the other to go on, from this step
  std::uint64_t waits_for_ = 0;
  std::deque<RecordedEvent> mine_, theirs_;                          ///< in the order of their steps
  std::map<std::uint64_t, std::uint64_t> my_hashes_, their_hashes_;  ///< not compared yet
  std::optional<std::string> trouble_;
  std::optional<std::uint64_t> diverged_;
};

}  // namespace fracture::game
