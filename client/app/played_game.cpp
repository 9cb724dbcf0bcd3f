#include "client/app/played_game.hpp"

#include <cstdio>
#include <future>
#include <utility>

#include "client/app/output_places.hpp"
#include "client/app/recorded_options.hpp"
#include "client/app/sound_track.hpp"

namespace fracture::app {

void PlayedGame::begin(scenes::Scene scene, const Options& options, const nlohmann::json& header,
                       std::shared_ptr<const game::Recording> recording) {
  options_ = options;
  answers_ = std::make_shared<game::KeptAnswers>();
  if (std::unique_ptr<LiveGame> played = rewind_.clear()) {
    halt(*played);
    background_.retire(std::move(played));
  }
  const bool goes_on_with = recording != nullptr;
  std::unique_ptr<LiveGame> made = make(std::move(scene), header, std::move(recording));
  background_.retire(std::move(game_));
  if (goes_on_with)
    rewind_.begin(std::move(made));
  else
    game_ = std::move(made);
}

/// Makes a game that begins as the header says, or one that replays a recording. Halts the current game.
std::unique_ptr<LiveGame> PlayedGame::make(scenes::Scene scene, const nlohmann::json& header,
                                           std::shared_ptr<const game::Recording> recording) {
  if (game_) halt(*game_);
  game::GameSettings settings;
  settings.seed = options_.seed;
  settings.anticipate = options_.anticipate;
  settings.overrides = header.at("parameters");
  settings.world.max_witnessed = kMostWitnessed;
  settings.history = std::make_shared<game::History>(header);
  settings.answers = answers_;
  settings.replay = std::move(recording);
  if (auto recorder = recorder_for(options_.log, header))
    settings.recorder = std::move(*recorder);
  else
    note_(recorder.error().detail);
  return std::make_unique<LiveGame>(
      std::make_unique<game::Game>(std::move(scene), client_, std::move(settings)), options_.seed);
}

/// Waits for the current step. Two running games on one client would take each other's answers, and one game
/// must not write into the other's file.
void PlayedGame::halt(LiveGame& live) {
  live.simulation.halt();
  const game::Game& game = live.simulation.game();
  if (patterns_.empty()) patterns_ = game.patterns();
  if (game.settings().recorder) game.settings().recorder->finish();
}

bool PlayedGame::frame(Tick tick, double seconds, bool back) {
  if (rewind_.playing()) return catch_up(tick, seconds);
  if (!game_) return false;
  const bool stands = go_back(seconds, back);
  tick.running = tick.running && !stands;
  for (std::string& said : game_->frame(tick, seconds)) note_(std::move(said));
  if (!stands) rewind_.follow(now()->moment);
  if (patterns_.empty() && now()->patterns) patterns_ = *now()->patterns;
  if (!std::exchange(too_long_, now()->history_full) && too_long_)
    note_(
        "This game is now too long to record. F5 saves only its beginning, and B cannot rewind. R starts a new game.");
  return false;
}

/// Returns whether the game pauses for this.
bool PlayedGame::go_back(double seconds, bool held) {
  if (held) {
    if (now()->history_full) {
      note_("This game is too long to rewind. R starts a new game.");
      return false;
    }
    rewind_.hold(now()->moment, game_->simulation.step_length(), seconds);
    char text[64];
    std::snprintf(text, sizeof text, "%.1f s back", rewind_.seconds_back());
    note_(text);
    return true;
  }
  if (!rewind_.held()) return false;
  halt(*game_);
  const game::Game& game = game_->simulation.game();
  auto recording = std::make_shared<const game::Recording>(game.settings().history->until(rewind_.release()));
  rewind_.begin(make(game.scene(), recording->header, recording));
  return true;
}

bool PlayedGame::catch_up(const Tick& tick, double seconds) {
  std::optional<Rewind::Played> played = rewind_.play_on(tick, seconds);
  if (!played) {
    note_("replaying the game: " + std::to_string(rewind_.percent()) + " %");
    return false;
  }
  const bool another =
      game_ != nullptr;  // null: no other game was on screen, so the view already shows this one
  background_.retire(std::exchange(game_, std::move(played->game)));
  note_(played->diverged ? "Step " + std::to_string(*played->diverged) +
                               " differs from the recording; the game continues from the new state."
                         : "the game continues");
  return another;
}

std::vector<sound::Voice> PlayedGame::take_voices() {
  return game_ ? game_->playback.take_voices() : std::vector<sound::Voice>();
}

/// Posts a command that has no note for the player.
void PlayedGame::post(std::function<void(game::Game&)> command) {
  if (!game_) return;
  game_->simulation.post([command = std::move(command)](game::Game& game) {
    command(game);
    return std::string();
  });
}

void PlayedGame::use(Tool tool, const glm::dvec3& eye, const glm::dvec3& direction) {
  if (!goes_on()) return;
  game_->simulation.post([tool, eye, direction](game::Game& game) {
    return use_tool(tool, game, eye, direction) ? std::string() : "there is nothing here to explode";
  });
}

void PlayedGame::step_once() {
  if (goes_on()) game_->simulation.step_once();
}

void PlayedGame::set_overrides(nlohmann::json overrides) {
  if (goes_on())
    post([overrides = std::move(overrides)](game::Game& game) { game.set_overrides(overrides); });
}

void PlayedGame::save(const std::string& folder) {
  if (!game_) return;
  const std::string path = unused_name(folder, "game", ".jsonl");
  const auto saved = std::make_shared<std::promise<game::Recording>>();
  background_.write_recording(saved->get_future(), path);
  post([saved](game::Game& game) {
    const game::History& history = *game.settings().history;
    saved->set_value(history.until(history.steps()));
  });
  note_((now()->history_full ? "saved the beginning of this long game as " : "saved the game as ") + path +
        ": --continue plays it");
}

}  // namespace fracture::app
