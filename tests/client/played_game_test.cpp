// The actions of a player in the window's game, without a window.
#include "client/app/played_game.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "client/app/recorded_options.hpp"
#include "tests/client/recorded_game.hpp"

namespace fracture::app {
namespace {

class PlayedGames : public game::Recordings {
 protected:
  PlayedGames() {
    options_.log = folder_ / "log.jsonl";
    begin();
  }
  void begin() {
    scenes::Scene boxes = scene();
    const nlohmann::json header = header_of(options_, boxes);
    game_->begin(std::move(boxes), options_, header, nullptr);
  }
  bool frame(bool back = false, double seconds = test::kFrame) {
    Tick tick;
    tick.seconds = seconds;
    tick.running = true;
    return game_->frame(tick, seconds, back);
  }
  void play_until(const std::string& what, const std::function<bool()>& done) {
    test::require_eventually(test::kPatience, what, [&] {
      frame();
      return done();
    });
  }
  void play_to(std::uint64_t step) {
    play_until("step " + std::to_string(step), [&] { return game_->now()->moment->step >= step; });
  }
  bool was_said(const std::string& note) const {
    return std::find(notes_.begin(), notes_.end(), note) != notes_.end();
  }
  void expect_to_be_played_again(const std::string& path) {
    const Expected<game::Recording> read = game::read_recording(path);
    ASSERT_TRUE(read) << read.error().detail;
    EXPECT_GT(read->hashes.size(), 0u);
    game::GameSettings settings;
    settings.replay = std::make_shared<const game::Recording>(*read);
    game::Game again(scene(), client_, settings);
    play_again(again);
    EXPECT_FALSE(again.figures().diverged) << path << ", step " << *again.figures().diverged;
  }

  test::FakeServer server_{[this](const test::FakeRequest& request) { return answer(request); }};
  protocol::Client client_{test::settings_for(server_)};
  std::vector<std::string> notes_;
  Options options_;
  std::unique_ptr<Background> background_ = std::make_unique<Background>();
  std::unique_ptr<PlayedGame> game_ = std::make_unique<PlayedGame>(
      client_, *background_, [this](std::string text) { notes_.push_back(std::move(text)); });
};

TEST_F(PlayedGames, ToolsActOnTheGame) {
  play_to(2);
  ASSERT_TRUE(game_->goes_on());
  game_->use(Tool::kBall, {0, 1, 8}, {0, 0, -1});
  game_->use(Tool::kWreckingBall, {5, 1, 8}, {0, 0, -1});
  play_until("two balls", [&] { return game_->now()->moment->balls.size() == 2; });
  EXPECT_LT(game_->now()->moment->balls[0].radius, game_->now()->moment->balls[1].radius);
  game_->use(Tool::kExplosion, {0, 5, 8}, {0, 1, 0});
  play_until("the note of an explosion in the sky",
             [&] { return was_said("there is nothing here to explode"); });
}

TEST_F(PlayedGames, GoBackAndOnFromThere) {
  play_to(150);
  const std::uint64_t last = game_->now()->moment->step;
  EXPECT_FALSE(frame(true, 0.1));
  EXPECT_FALSE(frame(true, 0.1));
  ASSERT_NE(game_->past(), nullptr);
  const std::uint64_t back = game_->past()->step;
  EXPECT_LT(back, last);
  EXPECT_FALSE(game_->goes_on());
  game_->use(Tool::kBall, {0, 1, 8}, {0, 0, -1});  // a ball in the past is ignored
  bool another = false;
  test::require_eventually(test::kPatience, "the game to be played again", [&] {
    another = frame() || another;
    return game_->goes_on();
  });
  EXPECT_TRUE(another);
  EXPECT_EQ(game_->past(), nullptr);
  EXPECT_TRUE(was_said("the game continues"));
  EXPECT_TRUE(game_->now()->moment->balls.empty());
  play_to(back + 20);
  game_ = nullptr;
  background_ = nullptr;
  expect_to_be_played_again(options_.log);
}

TEST_F(PlayedGames, AreSavedAsTheyAreWhenItIsAskedForAndAnotherOneBegins) {
  play_to(40);
  const std::string saves = folder_ / "saves";
  std::filesystem::create_directories(saves);
  game_->save(saves);
  begin();  // at once; earlier requests are still completed
  play_to(20);
  EXPECT_TRUE(game_->goes_on());
  game_ = nullptr;
  background_ = nullptr;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(saves)) {
    ++files;
    expect_to_be_played_again(entry.path().string());
  }
  EXPECT_EQ(files, 1u);
  expect_to_be_played_again(options_.log);
}

}  // namespace
}  // namespace fracture::app
