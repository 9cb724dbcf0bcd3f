// Rewinding the window's game, without a window.
#include "client/app/rewind.hpp"

#include <gtest/gtest.h>

#include "tests/client/recorded_game.hpp"

namespace fracture::app {
namespace {

class Rewinds : public game::Recordings {
 protected:
  game::GameSettings kept() const {
    game::GameSettings settings;
    settings.max_requests = 2;
    settings.history = std::make_shared<game::History>(nlohmann::json::object());
    settings.answers = answers_;
    return settings;
  }
  static Tick running() {
    Tick tick;
    tick.seconds = test::kFrame;
    tick.running = true;
    return tick;
  }
  static std::optional<Rewind::Played> play_again(Rewind& rewind) {
    std::optional<Rewind::Played> played;
    test::require_eventually(test::kPatience, "the game to be played again", [&] {
      EXPECT_NE(rewind.playing(), nullptr);
      EXPECT_LE(rewind.percent(), 100);
      played = rewind.play_on({}, test::kFrame);
      return played.has_value();
    });
    return played;
  }

  test::FakeServer server_{[this](const test::FakeRequest& request) { return answer(request); }};
  protocol::Client client_{test::settings_for(server_)};
  std::shared_ptr<game::KeptAnswers> answers_ = std::make_shared<game::KeptAnswers>();
};

TEST_F(Rewinds, ShowThePastAndEndInIt) {
  LiveGame live(std::make_unique<game::Game>(scene(), client_, kept()), 1);
  const double step_length = live.simulation.step_length();
  const auto now = [&] { return live.playback.latest().moment; };
  Rewind rewind;
  test::require_eventually(test::kPatience, "all answers", [&] {
    live.frame(running(), test::kFrame);
    rewind.follow(now());
    return now()->step > 200 && live.playback.latest().figures.swaps >= 3;
  });
  const std::uint64_t last = now()->step;
  EXPECT_EQ(rewind.shown(), nullptr);
  EXPECT_FALSE(rewind.held());
  // Half a second at twice the game's speed, then farther back than there are moments.
  const Rewind::Moment held = now();
  rewind.hold(held, step_length, 0.25);
  rewind.hold(held, step_length, 0.25);
  ASSERT_TRUE(rewind.held());
  ASSERT_NE(rewind.shown(), nullptr);
  EXPECT_LE(rewind.shown()->step, last - 120);
  EXPECT_GT(rewind.shown()->step, last - 135);
  EXPECT_NEAR(rewind.seconds_back(), 1, 0.15);
  rewind.hold(held, step_length, 60);
  const std::uint64_t oldest = rewind.shown()->step;
  EXPECT_LT(oldest, last - 135);
  const game::Moment shown = *rewind.shown();

  const std::uint64_t step = rewind.release();
  EXPECT_EQ(step, oldest);
  EXPECT_FALSE(rewind.held());
  EXPECT_NE(rewind.shown(), nullptr) << "it is seen until the game is there";
  live.simulation.halt();
  game::GameSettings again = kept();
  again.replay =
      std::make_shared<const game::Recording>(live.simulation.game().settings().history->until(step));
  rewind.begin(std::make_unique<LiveGame>(std::make_unique<game::Game>(scene(), client_, again), 1));
  std::optional<Rewind::Played> played = play_again(rewind);
  EXPECT_FALSE(played->diverged);
  EXPECT_EQ(rewind.playing(), nullptr);
  EXPECT_EQ(rewind.shown(), nullptr);
  const Playback& playback = played->game->playback;
  const game::Moment there = *playback.latest().moment;
  EXPECT_EQ(there.step, step);
  EXPECT_EQ(playback.moment().step, step) << "it is seen at once";
  ASSERT_EQ(there.parts.size(), shown.parts.size());
  for (std::size_t k = 0; k < there.parts.size(); ++k) {
    ASSERT_EQ(there.parts[k].broken == nullptr, shown.parts[k].broken == nullptr) << k;
    EXPECT_EQ(there.parts[k].whole.position, shown.parts[k].whole.position) << k;
    for (std::size_t f = 0; f < there.parts[k].fragments.size(); ++f)
      EXPECT_EQ(there.parts[k].fragments[f].asset_to_world.position,
                shown.parts[k].fragments[f].asset_to_world.position)
          << k << " " << f;
  }
  // The game goes on with its own history.
  test::require_eventually(test::kPatience, "a step", [&] {
    played->game->frame(running(), test::kFrame);
    return playback.latest().moment->step > step;
  });
  played->game->simulation.halt();
  const game::GameSettings& settings = played->game->simulation.game().settings();
  EXPECT_FALSE(settings.replay);
  EXPECT_EQ(settings.history->until(step).hashes, again.replay->hashes);
}

TEST_F(Rewinds, AGameThatBecomesAnotherIsHandedOverAtThatStep) {
  game::Game game(scene(), client_, kept());
  test::require_eventually(test::kPatience, "steps", [&] {
    game.advance(test::kFrame, true);
    return game.world().steps() > 60;
  });
  game::Recording other = game.settings().history->until(60);
  other.hashes[20] ^= 1;
  game::GameSettings again = kept();
  again.replay = std::make_shared<const game::Recording>(other);
  Rewind rewind;
  rewind.begin(std::make_unique<LiveGame>(std::make_unique<game::Game>(scene(), client_, again), 1));
  const std::optional<Rewind::Played> played = play_again(rewind);
  EXPECT_EQ(played->diverged, std::optional<std::uint64_t>(20));
  EXPECT_EQ(played->game->playback.latest().moment->step, 21u);
}

}  // namespace
}  // namespace fracture::app
