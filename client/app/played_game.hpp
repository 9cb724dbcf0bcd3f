// The game in a window: the current game, its replay after going back, and the player's actions. Simulations
// run on their own threads. This class is used by frames and waits for a simulation only when one ends.
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
  /// `client` and `background` must outlive it; `note` receives messages for the player.
  PlayedGame(protocol::Client& client, Background& background, std::function<void(std::string)> note)
      : client_(client), background_(background), note_(std::move(note)) {}

  /// Begins another game, recorded as the options say. If a recording is given, which must begin with this
  /// header, the game continues from its end.
  void begin(scenes::Scene scene, const Options& options, const nlohmann::json& header,
             std::shared_ptr<const game::Recording> recording);
  /// Runs a frame that took this many seconds. `back`: whether the rewind key is held. Returns whether
  /// another game is shown from now on.
  bool frame(Tick tick, double seconds, bool back);

  /// The game that is shown; null if there is none yet.
  const LiveGame* seen() const { return game_ ? game_.get() : rewind_.playing(); }
  /// A past moment to show instead of the game; null if there is none.
  const game::Moment* past() const { return rewind_.shown(); }
  /// The newest state. The picture shows a slightly earlier one. Null before the game starts and while a
  /// recording is replayed.
  const Snapshot* now() const { return game_ ? &game_->playback.latest() : nullptr; }
  /// Whether the game accepts the player's actions.
  bool goes_on() const { return game_ && !rewind_.playing() && !rewind_.held(); }
  std::vector<sound::Voice> take_voices();
  /// Game::patterns() of any of the player's games.
  const std::string& patterns() const { return patterns_; }

  // These do nothing unless goes_on(). For save(), it is enough that there is a game.
  void use(Tool tool, const glm::dvec3& eye, const glm::dvec3& direction);
  void step_once();
  void set_overrides(nlohmann::json overrides);
  /// Saves into a folder; the file name contains the time.
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
  std::shared_ptr<game::KeptAnswers> answers_;  ///< of this game, kept when it goes back
  Rewind rewind_;
  std::string patterns_;
  bool too_long_ = false;
};

}  // namespace fracture::app
