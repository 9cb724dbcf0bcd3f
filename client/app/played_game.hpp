// The game of a window: the one that goes on, the one before it that is played again after going back, and what the player
// does in it. Simulations run on threads of their own; this is their frame's side, and waits for them only where one ends.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "client/app/background.hpp"
#include "client/app/options.hpp"
#include "client/app/panel.hpp"
#include "client/app/rewind.hpp"
#include "client/protocol/client.hpp"

namespace fracture::app {

class PlayedGame {
 public:
  /// `client` and `background` outlive it; `note` takes what there is to say to people.
  PlayedGame(protocol::Client& client, Background& background, std::function<void(std::string)> note)
      : client_(client), background_(background), note_(std::move(note)) {}

  /// Another game, recorded as the options say. With a recording of one that began with this header it goes on from its end.
  void begin(scenes::Scene scene, const Options& options, const nlohmann::json& header,
             std::shared_ptr<const game::Recording> recording);
  /// A frame that took so many seconds; `back`: the key that goes back is held. Whether what is seen from now on is another game.
  bool frame(Tick tick, double seconds, bool back);

  /// The game that is seen; null: none yet.
  const LiveGame* seen() const { return game_ ? game_.get() : rewind_.playing(); }
  /// Seen instead of what the game is; null: nothing.
  const game::Moment* past() const { return rewind_.shown(); }
  /// What it is, which is a little later than what is seen of it; null: no game yet, or a recording is played before it.
  const Snapshot* now() const { return game_ ? &game_->playback.latest() : nullptr; }
  /// It takes what the player does.
  bool goes_on() const { return game_ && !rewind_.playing() && !rewind_.held(); }
  std::vector<sound::Voice> take_voices();
  /// Game::patterns() of any of its games.
  const std::string& patterns() const { return patterns_; }

  // Where it goes on (save(): where there is one); else nothing.
  void use(Tool tool, const glm::dvec3& eye, const glm::dvec3& direction);
  void step_once();
  void set_overrides(nlohmann::json overrides);
  /// Into a folder, by the time of day.
  void save(const std::string& folder);

 private:
  std::unique_ptr<LiveGame> make(scenes::Scene scene, const nlohmann::json& header,
                                 std::shared_ptr<const game::Recording> recording);
  void halt(LiveGame& live);
  bool go_back(double seconds, bool held);
  bool catch_up(const Tick& tick, double seconds);
  void post(std::function<void(game::Game&)> command);

  protocol::Client& client_;
  Background& background_;
  const std::function<void(std::string)> note_;
  Options options_;
  std::unique_ptr<LiveGame> game_;
  std::shared_ptr<game::KeptAnswers> answers_;  ///< of this game, however often it goes back
  Rewind rewind_;
  std::string patterns_;
  bool too_long_ = false;
};

}  // namespace fracture::app
