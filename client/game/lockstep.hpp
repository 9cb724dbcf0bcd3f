// One game on two machines: each computes it from the same start and from both players' actions. No geometry
// is sent.
//
// JSON lines, as in a recording (recording.hpp). First, both sides send the header of the game, which must be
// the same:
//
//   {"format": "fracture-lockstep-1", "rules": 6, "answer_steps": 6, "delay": 12, "scene": …, "seed": …, "digest": …}
//   {"step": 48, "throw": …}       this player's action takes effect `delay` steps later, on both machines
//   {"step": 35, "hash": "90ab…"}  after each step. It also means that all of this player's actions before step
//                                  36 + delay have been sent: the other side may compute up to there, and no further
//   {"refused": "…"}               there is no game, and why; the last line
//
// So no player is more than `delay` steps ahead, and the first step that differs is detected at once.
// Simultaneous actions have a fixed order: the inviting player's come first. The game is reproducible
// (GameSettings::fixed_latency) and uses the scene's eye, whatever each player looks at.
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

/// The header of a recording, plus the members that lockstep needs.
nlohmann::json lockstep_header(nlohmann::json header, unsigned answer_steps, unsigned delay = kLockstepDelay);
/// Fails with kBadJson if it is not a header of this version's lockstep, and kUnavailable if it is a refusal.
Expected<nlohmann::json> read_lockstep_header(const std::string& line);

class Lockstep {
 public:
  enum class Seat { kHost, kGuest };
  /// `game` was created from the header. It must outlive this object, and so must the link. `theirs`: the
  /// other player's header if it has already been read, else null. `patience`: for a player who is connected
  /// but does not continue. It is longer than a client waits for its server.
  Lockstep(Game& game, PeerLink& link, Seat seat, nlohmann::json header, nlohmann::json theirs = nullptr,
           std::chrono::milliseconds patience = std::chrono::seconds(90));

  void throw_ball(const glm::dvec3& from, const glm::dvec3& velocity, const scenes::Ball& ball = {});
  void explode(const world::Blast& blast);

  /// Whether the next step can be played. Polls; never blocks.
  bool ready();
  /// Call it only if ready().
  void step();
  /// Whether the other player has played every step that this one has, with the same bits. Polls.
  bool level();
  /// Ends the game and tells the other player why.
  void leave(const std::string& why);
  /// Why the game is over, for people.
  const std::optional<std::string>& trouble() const { return trouble_; }
  /// The first step that differed between the two.
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
  bool met_ = false;                              ///< the other header matched this one
  std::uint64_t heard_ = 0;                       ///< number of steps that the other player has played
  std::optional<Clock::time_point> waits_since_;  ///< start of the wait for the other player to continue
  std::uint64_t waits_for_ = 0;
  std::deque<RecordedEvent> mine_, theirs_;                          ///< in step order
  std::map<std::uint64_t, std::uint64_t> my_hashes_, their_hashes_;  ///< not compared yet
  std::optional<std::string> trouble_;
  std::optional<std::uint64_t> diverged_;
};

}  // namespace fracture::game
