// Going back in the window's game, without a window.
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
  test::FakeServer server_{[this](const test::FakeRequest& request) { return answer(request); }};
  protocol::Client client_{test::settings_for(server_)};
  std::shared_ptr<game::KeptAnswers> answers_ = std::make_shared<game::KeptAnswers>();
};

TEST_F(Rewinds, ShowThePastAndEndInIt) {
  game::Game game(scene(), client_, kept());
  Rewind rewind;
  test::require_eventually(test::kPatience, "all answers", [&] {
    game.advance(test::kFrame, true);
    rewind.follow(game);
    return game.world().steps() > 200 && game.figures().swaps >= 3 &&
           game.open_requests() + game.waiting_requests() == 0;
  });
  const std::uint64_t now = game.world().steps();
  EXPECT_EQ(rewind.shown(), nullptr);
  EXPECT_FALSE(rewind.held());
  // Half a second at twice the speed of the game; then farther than there is anything.
  rewind.hold(game, 0.25);
  rewind.hold(game, 0.25);
  ASSERT_TRUE(rewind.held());
  ASSERT_NE(rewind.shown(), nullptr);
  EXPECT_LE(rewind.shown()->step, now - 120);
  EXPECT_GT(rewind.shown()->step, now - 130);
  EXPECT_NEAR(rewind.seconds_back(), 1, 0.1);
  rewind.hold(game, 60);
  const std::uint64_t oldest = rewind.shown()->step;
  EXPECT_LT(oldest, now - 130);
  const game::Moment shown = *rewind.shown();

  const std::uint64_t step = rewind.release();
  EXPECT_EQ(step, oldest);
  EXPECT_FALSE(rewind.held());
  EXPECT_NE(rewind.shown(), nullptr) << "it is seen until the game is there";
  game::GameSettings again = kept();
  again.replay = std::make_shared<const game::Recording>(game.settings().history->until(step));
  rewind.begin(std::make_unique<game::Game>(scene(), client_, again), 1);
  std::optional<Rewind::Played> played;
  test::require_eventually(test::kPatience, "the game to be played again", [&] {
    EXPECT_NE(rewind.playing(), nullptr);
    EXPECT_LE(rewind.percent(), 100);
    played = rewind.play_on();
    return played.has_value();
  });
  EXPECT_FALSE(played->diverged);
  EXPECT_EQ(rewind.playing(), nullptr);
  EXPECT_EQ(rewind.shown(), nullptr);
  EXPECT_EQ(played->game->world().steps(), step);
  const game::Moment there = game::moment_of(*played->game);
  ASSERT_EQ(there.parts.size(), shown.parts.size());
  for (std::size_t k = 0; k < there.parts.size(); ++k) {
    ASSERT_EQ(there.parts[k].broken == nullptr, shown.parts[k].broken == nullptr) << k;
    EXPECT_EQ(there.parts[k].whole.position, shown.parts[k].whole.position) << k;
    for (std::size_t f = 0; f < there.parts[k].fragments.size(); ++f)
      EXPECT_EQ(there.parts[k].fragments[f].asset_to_world.position,
                shown.parts[k].fragments[f].asset_to_world.position)
          << k << " " << f;
  }
  EXPECT_FALSE(played->game->settings().replay);
  // It has a history of its own, and goes on.
  EXPECT_EQ(played->game->settings().history->until(step).hashes, again.replay->hashes);
  played->game->advance(test::kFrame, true);
  EXPECT_GT(played->game->world().steps(), step);
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
  rewind.begin(std::make_unique<game::Game>(scene(), client_, again), 1);
  std::optional<Rewind::Played> played;
  test::require_eventually(test::kPatience, "the game to be played again", [&] {
    played = rewind.play_on();
    return played.has_value();
  });
  EXPECT_EQ(played->diverged, std::optional<std::uint64_t>(20));
  EXPECT_EQ(played->game->world().steps(), 21u);
}

}  // namespace
}  // namespace fracture::app
