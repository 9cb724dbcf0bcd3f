// A game on its own thread: what frames may rely on. The test decides when steps are made, so nothing here
// depends on time.
#include "client/app/simulation.hpp"

#include <gtest/gtest.h>

#include <future>

#include "client/app/playback.hpp"
#include "tests/client/recorded_game.hpp"

namespace fracture::app {
namespace {

constexpr double kFrame = 1.0 / 128;  // seconds, whose sums are exact

class Simulations : public game::Recordings {
 protected:
  game::GameSettings settings() const {
    game::GameSettings settings;
    settings.max_requests = 2;
    settings.world.step = kFrame;
    settings.world.max_witnessed = 100;
    settings.history = std::make_shared<game::History>(nlohmann::json::object());
    return settings;
  }
  std::unique_ptr<game::Game> make_game(game::GameSettings with) {
    return std::make_unique<game::Game>(scene(), client_, std::move(with));
  }
  void begin() {
    simulation_ = std::make_unique<Simulation>(make_game(settings()), 1);
    look();
  }
  static Tick running(double seconds) {
    Tick tick;
    tick.seconds = seconds;
    tick.running = true;
    return tick;
  }
  /// Takes the snapshots that exist.
  void look() {
    for (auto& snapshot : simulation_->take()) {
      notes_.insert(notes_.end(), snapshot->notes.begin(), snapshot->notes.end());
      seen_.push_back(std::move(snapshot));
    }
  }
  const Snapshot& last() const { return *seen_.back(); }
  void wait_for_step(std::uint64_t step) {
    test::require_eventually(test::kPatience, "step " + std::to_string(step), [&] {
      look();
      return last().moment->step >= step;
    });
  }
  void wait_for_note(const std::string& note) {
    test::require_eventually(test::kPatience, "the note " + note, [&] {
      look();
      return std::find(notes_.begin(), notes_.end(), note) != notes_.end();
    });
  }
  /// Expects that all owed steps are made, and no more.
  void expect_steps(std::uint64_t step) {
    wait_for_step(step);
    const std::string mark = "mark " + std::to_string(++marks_);
    simulation_->post([mark](game::Game&) { return mark; });
    wait_for_note(mark);
    EXPECT_EQ(last().moment->step, step);
  }
  /// Posts a step that begins, and ends when the test says so, or at the latest after all patience.
  void post_long_step(Simulation& simulation) {
    simulation.post([this](game::Game& game) {
      began_.set_value();
      ended_.get_future().wait_for(test::kPatience);
      game.step();
      return std::string("made");
    });
    ASSERT_EQ(began_.get_future().wait_for(test::kPatience), std::future_status::ready);
  }

  test::FakeServer server_{[this](const test::FakeRequest& request) { return answer(request); }};
  protocol::Client client_{test::settings_for(server_)};
  std::vector<std::shared_ptr<const Snapshot>> seen_;
  std::vector<std::string> notes_;
  std::promise<void> began_, ended_;
  int marks_ = 0;
  std::unique_ptr<Simulation> simulation_;
};

TEST_F(Simulations, AFrameIsServedWhileAStepIsAtWork) {
  LiveGame live(make_game(settings()), 1);
  const game::Moment beginning = live.playback.moment();
  post_long_step(live.simulation);
  for (int frame = 0; frame < 100; ++frame) {
    EXPECT_TRUE(live.frame(running(kFrame), kFrame).empty());
    ASSERT_EQ(live.playback.moment().parts.size(), 4u);
    EXPECT_EQ(live.playback.moment().parts[0].whole.position, beginning.parts[0].whole.position);
  }
  live.simulation.post([](game::Game&) { return std::string("after it"); });
  live.simulation.step_once();
  ended_.set_value();
  std::vector<std::string> notes;
  test::require_eventually(test::kPatience, "the notes", [&] {
    for (std::string& note : live.frame({}, kFrame)) notes.push_back(std::move(note));
    return notes.size() >= 2;
  });
  EXPECT_EQ(notes, (std::vector<std::string>{"made", "after it"}));
}

TEST_F(Simulations, MakesTheStepsThatFramesGiveTimeFor) {
  begin();
  EXPECT_EQ(last().moment->step, 0u);
  simulation_->pass({});
  expect_steps(0);  // paused
  simulation_->step_once();
  simulation_->step_once();
  expect_steps(2);
  simulation_->pass(running(3 * kFrame));
  expect_steps(5);
  for (int k = 0; k < 8; ++k) simulation_->pass(running(kFrame / 4));  // slow motion
  expect_steps(7);
  EXPECT_EQ(last().due, 7 * kFrame);
  simulation_->pass(running(kFrame / 2));
  simulation_->pass({});  // time owed before a pause does not count after it
  simulation_->pass(running(kFrame / 2));
  expect_steps(7);
}

TEST_F(Simulations, DropTimeThatTheyCannotMakeAndAreSeenLater) {
  begin();
  simulation_->pass(running(100 * kFrame));
  expect_steps(Simulation::kMostOwed);
  EXPECT_DOUBLE_EQ(last().due, 100 * kFrame);
  double due = 0;
  for (const auto& snapshot : seen_) {
    EXPECT_GE(snapshot->due, due);
    due = snapshot->due;
  }
}

TEST_F(Simulations, CommandsTakeEffectInTheirOrder) {
  begin();
  std::vector<int> order;  // written by the simulation's thread until a note says that it is done
  for (int k = 0; k < 20; ++k)
    simulation_->post([k, &order](game::Game&) {
      order.push_back(k);
      return std::string();
    });
  simulation_->post([](game::Game& game) {
    game.throw_ball({0.5, 0.5, 4}, {0, 0, -20});
    return std::string("thrown");
  });
  wait_for_note("thrown");
  ASSERT_EQ(order.size(), 20u);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  ASSERT_EQ(last().moment->balls.size(), 1u) << "also while paused";
  EXPECT_EQ(last().moment->balls[0].pose.position.z, 4);
  simulation_->step_once();
  expect_steps(1);
  EXPECT_LT(last().moment->balls[0].pose.position.z, 4);
}

TEST_F(Simulations, EndWhileAStepIsAtWorkWithWhatWasPostedBefore) {
  begin();
  post_long_step(*simulation_);
  int done = 0;
  simulation_->post([&](game::Game&) {
    ++done;
    return std::string();
  });
  simulation_->pass(running(6 * kFrame));
  std::future<void> end = std::async(std::launch::async, [this] { simulation_->halt(); });
  ended_.set_value();
  ASSERT_EQ(end.wait_for(test::kPatience), std::future_status::ready);
  EXPECT_EQ(done, 1);
  simulation_->post([&](game::Game&) {
    ++done;
    return std::string();
  });
  EXPECT_EQ(done, 2) << "at once";
  simulation_->halt();
  const std::uint64_t steps = simulation_->game().world().steps();
  EXPECT_GE(steps, 1u);
  simulation_->pass(running(kFrame));
  simulation_->take();
  EXPECT_EQ(simulation_->game().world().steps(), steps);
}

TEST_F(Simulations, PiecesBeginWhereTheWholeIs) {
  begin();
  test::require_eventually(test::kPatience, "a swap that is seen", [&] {
    simulation_->pass(running(kFrame));
    look();
    return last().figures.swaps > 0;
  });
  const auto swap = std::find_if(
      seen_.begin(), seen_.end(),
      [](const std::shared_ptr<const Snapshot>& snapshot) { return snapshot->figures.swaps > 0; });
  ASSERT_NE(swap, seen_.begin());
  const Snapshot &before = **std::prev(swap), &after = **swap;
  EXPECT_EQ(before.moment->step, after.moment->step);
  EXPECT_EQ(before.due, after.due);
  bool any = false;
  for (std::size_t k = 0; k < after.moment->parts.size(); ++k) {
    const game::Moment::Part &whole = before.moment->parts[k], &pieces = after.moment->parts[k];
    if (whole.broken == pieces.broken) continue;
    any = true;
    for (const world::FragmentState& fragment : pieces.fragments)
      EXPECT_NEAR(glm::distance(fragment.asset_to_world.position, whole.whole.position), 0, 1e-9);
  }
  EXPECT_TRUE(any);
}

TEST_F(Simulations, WhatTheyRecordIsPlayedAgainToTheSameBits) {
  const std::string log = folder_ / "game.jsonl";
  game::GameSettings with = settings();
  with.recorder = std::make_shared<game::Recorder>(*game::Recorder::create(log, {{"scene", "boxes"}}));
  simulation_ = std::make_unique<Simulation>(make_game(with), 1);
  look();
  int frame = 0;
  test::require_eventually(test::kPatience, "all answers", [&] {
    if (frame == 20)
      simulation_->post([](game::Game& game) {
        game.throw_ball({0.5, 0.5, 4}, {0.1, 1.0 / 3, -20});
        game.explode({{3, 0.2, 1}, 300, 4});
        return std::string();
      });
    if (frame == 50)
      simulation_->post([](game::Game& game) {
        game.set_overrides({{"sites", 12}});
        return std::string();
      });
    Tick tick = running(2 * kFrame);
    tick.eye = {0.1 * frame, 1, 5};
    simulation_->pass(tick);
    look();
    return ++frame > 150 && last().figures.swaps >= 3 && last().moment->step > 150;
  });
  simulation_->halt();
  const std::uint64_t last = simulation_->game().world().fingerprint();
  ASSERT_TRUE(with.recorder->finish());
  const Expected<game::Recording> read = game::read_recording(log);
  ASSERT_TRUE(read) << read.error().detail;
  EXPECT_EQ(read->hashes.back(), last);
  EXPECT_EQ(read->hashes, with.history->until(with.history->steps()).hashes);
  game::GameSettings again = replaying(*read);
  again.world.step = kFrame;
  game::Game played(scene(), client_, again);
  play_again(played);
  EXPECT_FALSE(played.figures().diverged) << *played.figures().diverged;
  EXPECT_EQ(played.world().fingerprint(), last);
}

TEST_F(Simulations, ARecordingIsPlayedToItsEndBeforeTimeCounts) {
  begin();
  simulation_->pass(running(6 * kFrame));
  expect_steps(6);
  simulation_->halt();
  game::GameSettings again = settings();
  again.replay = std::make_shared<const game::Recording>(simulation_->game().settings().history->until(4));
  simulation_ = std::make_unique<Simulation>(make_game(again), 1);
  seen_.clear();
  look();
  EXPECT_TRUE(seen_.front()->played_again_percent);
  test::require_eventually(test::kPatience, "its end", [&] {
    look();
    return !last().played_again_percent;
  });
  expect_steps(4);
  EXPECT_FALSE(last().figures.diverged);
  simulation_->pass(running(2 * kFrame));
  expect_steps(6);
}

}  // namespace
}  // namespace fracture::app
