// Frames between the snapshots of a game: motion is smooth, and no object is shown that does not exist.
#include "client/app/playback.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fracture::app {
namespace {

constexpr double kStep = 1.0 / 120;

using Moments = std::vector<std::shared_ptr<const Snapshot>>;

/// A snapshot with one object at this x.
Snapshot whole_at(double due, std::uint64_t step, double x) {
  game::Moment moment;
  moment.step = step;
  moment.parts.emplace_back().whole.position = {x, 0, 0};
  Snapshot snapshot;
  snapshot.due = due;
  snapshot.moment = std::make_shared<const game::Moment>(std::move(moment));
  snapshot.debris = std::make_shared<const effects::Debris>();
  return snapshot;
}
Snapshot with(Snapshot snapshot, const std::function<void(game::Moment&)>& change) {
  game::Moment moment = *snapshot.moment;
  change(moment);
  snapshot.moment = std::make_shared<const game::Moment>(std::move(moment));
  return snapshot;
}
Moments list(const std::vector<Snapshot>& snapshots) {
  Moments all;
  for (const Snapshot& snapshot : snapshots) all.push_back(std::make_shared<const Snapshot>(snapshot));
  return all;
}
/// Advances the playhead by `seconds`.
void pass(Playback& playback, double seconds) { playback.pass(seconds / Playback::kSpeed, kStep); }
double x_of(const Playback& playback) { return playback.moment().parts.at(0).whole.position.x; }

TEST(Playback, PosesBetweenTwoSnapshotsLieBetweenThem) {
  const auto turned = [](double angle) {
    return [angle](game::Moment& moment) {
      moment.parts[0].whole.rotation = glm::angleAxis(angle, glm::dvec3(0, 1, 0));
    };
  };
  Playback playback(list({with(whole_at(0, 7, 2), turned(0.2)), with(whole_at(kStep, 8, 4), turned(0.6))}));
  EXPECT_DOUBLE_EQ(x_of(playback), 2);
  pass(playback, kStep / 4);
  EXPECT_NEAR(x_of(playback), 2.5, 1e-12);
  EXPECT_NEAR(glm::angle(playback.moment().parts[0].whole.rotation), 0.3, 1e-12);
  pass(playback, kStep / 2);
  EXPECT_NEAR(x_of(playback), 3.5, 1e-12);
  EXPECT_NEAR(glm::length(playback.moment().parts[0].whole.rotation), 1, 1e-12);
  EXPECT_EQ(playback.moment().step, 7u) << "the step after it is not seen before it is reached";
  pass(playback, kStep / 4);
  EXPECT_DOUBLE_EQ(x_of(playback), 4);
}

TEST(Playback, NothingIsSeenBeforeItIsKnown) {
  Playback playback(list({whole_at(0, 0, 0), whole_at(kStep, 1, 1)}));
  pass(playback, 1);
  EXPECT_DOUBLE_EQ(x_of(playback), 1);
  pass(playback, 1);
  EXPECT_DOUBLE_EQ(x_of(playback), 1);
  playback.add(list({whole_at(2 * kStep, 2, 2)}));
  pass(playback, kStep / 2);
  EXPECT_NEAR(x_of(playback), 1.5, 1e-12) << "time in which there was nothing new is not made up for";
}

TEST(Playback, FragmentsMoveAndFadeAndTheRestJumps) {
  const auto broken = std::make_shared<const game::Decoded>();
  const auto state = [](double x, float size, bool present) {
    world::FragmentState fragment;
    fragment.asset_to_world.position.x = x;
    fragment.size = size;
    fragment.present = present;
    return fragment;
  };
  const auto broken_into = [&](std::vector<world::FragmentState> fragments,
                               std::vector<world::BallState> balls) {
    return [=](game::Moment& moment) {
      moment.parts[0].broken = broken;
      moment.parts[0].fragments = fragments;
      moment.balls = balls;
    };
  };
  const Snapshot from = with(whole_at(0, 0, 0), broken_into({state(0, 1, true), state(5, 0.5f, true)},
                                                            {{1, {{1, 0, 0}}, 0.1}, {2, {{2, 0, 0}}, 0.1}}));
  Snapshot to = with(whole_at(kStep, 1, 0), broken_into({state(1, 0.5f, true), state(9, 0, false)},
                                                        {{2, {{4, 0, 0}}, 0.1}, {3, {{8, 0, 0}}, 0.1}}));
  to = with(to, [](game::Moment& moment) { moment.parts.emplace_back(); });
  Playback playback(list({from, to}));
  pass(playback, kStep / 2);
  const game::Moment& seen = playback.moment();
  ASSERT_EQ(seen.parts.size(), 1u) << "what appears is seen from its snapshot on";
  EXPECT_NEAR(seen.parts[0].fragments[0].asset_to_world.position.x, 0.5, 1e-12);
  EXPECT_NEAR(seen.parts[0].fragments[0].size, 0.75f, 1e-6f);
  EXPECT_TRUE(seen.parts[0].fragments[1].present) << "what goes is seen until then, where it was";
  EXPECT_EQ(seen.parts[0].fragments[1].asset_to_world.position.x, 5);
  ASSERT_EQ(seen.balls.size(), 2u);
  EXPECT_EQ(seen.balls[0].pose.position.x, 1) << "it is gone in the next";
  EXPECT_NEAR(seen.balls[1].pose.position.x, 3, 1e-12) << "by its number, not by its place";
  pass(playback, kStep / 2);
  EXPECT_EQ(seen.parts.size(), 2u);
  EXPECT_FALSE(seen.parts[0].fragments[1].present);
  EXPECT_EQ(seen.balls[1].pose.position.x, 8);
}

TEST(Playback, ASwapIsSeenAtItsTimeAndUploadedBefore) {
  const auto pieces = std::make_shared<const game::Decoded>(), next = std::make_shared<const game::Decoded>();
  const auto broken_at = [&](double x) {
    return [=](game::Moment& moment) {
      moment.parts[0].broken = pieces;
      moment.parts[0].fragments.resize(1);
      moment.parts[0].fragments[0].asset_to_world.position.x = x;
    };
  };
  // As a simulation publishes it: before the swap, after the swap at the same time, and after the step.
  Snapshot last = with(whole_at(2 * kStep, 2, 0), broken_at(2));
  last.coming.push_back({0, 0, next});
  Playback playback(
      list({whole_at(0, 0, 0), whole_at(kStep, 1, 1), with(whole_at(kStep, 1, 0), broken_at(1)), last}));
  std::vector<game::Game::Coming> coming = playback.coming();
  const auto has = [&](const std::shared_ptr<const game::Decoded>& wanted) {
    return std::any_of(coming.begin(), coming.end(),
                       [&](const game::Game::Coming& one) { return one.fragments == wanted; });
  };
  EXPECT_TRUE(has(pieces));
  EXPECT_TRUE(has(next));
  pass(playback, kStep / 2);
  EXPECT_FALSE(playback.moment().parts[0].broken);
  EXPECT_NEAR(x_of(playback), 0.5, 1e-12);
  pass(playback, kStep);
  ASSERT_EQ(playback.moment().parts[0].broken, pieces);
  EXPECT_NEAR(playback.moment().parts[0].fragments[0].asset_to_world.position.x, 1.5, 1e-12);
  coming = playback.coming();
  EXPECT_FALSE(has(pieces)) << "it is seen";
  EXPECT_TRUE(has(next));
}

TEST(Playback, ThingsAreHeardWhenTheyAreSeen) {
  Snapshot loud = whole_at(kStep, 1, 1);
  loud.voices.resize(2);
  Playback playback(list({whole_at(0, 0, 0), loud}));
  pass(playback, kStep / 2);
  EXPECT_TRUE(playback.take_voices().empty());
  pass(playback, kStep / 2);
  EXPECT_EQ(playback.take_voices().size(), 2u);
  EXPECT_TRUE(playback.take_voices().empty());
}

TEST(Playback, DebrisGoesOnBetweenSteps) {
  world::Witnessed seen;
  world::Crack crack;
  crack.point = {0, 50, 0};
  crack.normal = {1, 0, 0};
  crack.area = 1;
  seen.cracks.push_back(crack);
  const world::World world;
  auto debris = std::make_shared<effects::Debris>();
  debris->follow(world, seen, [](world::ObjectId) { return std::string("glass"); });
  ASSERT_FALSE(debris->crumbs().empty());
  Snapshot from = whole_at(0, 0, 0);
  from.debris = debris;
  Playback playback(list({from, whole_at(kStep, 1, 1)}));
  pass(playback, kStep / 2);
  ASSERT_EQ(playback.debris().crumbs().size(), debris->crumbs().size());
  EXPECT_NEAR(playback.debris().crumbs()[0].age, debris->crumbs()[0].age + static_cast<float>(kStep / 2),
              1e-6f);
}

/// The motion that frames of this length show if the game's steps arrive at certain times.
struct Seen {
  double least = 1e9, most = 0;  ///< distance per frame relative to its time
  double latest = 0;             ///< seconds behind the clock of the frames
};
Seen watch(double frame, double step_takes, double due_of_step) {
  Playback playback(list({whole_at(0, 0, 0)}));
  Seen seen;
  std::uint64_t step = 0;
  double last = 0;
  const int frames = static_cast<int>(6 / frame);
  for (int k = 1; k < frames; ++k) {
    // A frame has the steps that the frame before requested.
    const double clock = k * frame, asked = (k - 1) * frame;
    while (static_cast<double>(step + 1) * step_takes <= asked + 1e-9) {
      ++step;
      playback.add(list({whole_at(static_cast<double>(step) * due_of_step, step,
                                  static_cast<double>(step) * due_of_step)}));
    }
    playback.pass(frame, kStep);
    const double way = (x_of(playback) - last) / frame;
    last = x_of(playback);
    if (clock < 1) continue;  // the playback has found its delay
    seen.least = std::min(seen.least, way);
    seen.most = std::max(seen.most, way);
    seen.latest = std::max(seen.latest, clock - last);
  }
  return seen;
}

TEST(Playback, MotionIsEvenAtAnyRateOfFrames) {
  for (const double rate : {30.0, 50.0, 60.0, 75.0, 144.0, 240.0}) {
    const Seen seen = watch(1 / rate, kStep, kStep);
    EXPECT_GT(seen.least, 0.8) << rate;
    EXPECT_LT(seen.most, Playback::kSpeed + 1e-6) << rate;
    EXPECT_LT(seen.latest, 1.1 * (1 / rate + kStep)) << rate;
  }
}

TEST(Playback, MotionIsEvenWhereAStepTakesSeveralFrames) {
  for (const double step_takes : {0.04, 0.1}) {
    const Seen seen = watch(1.0 / 60, step_takes, step_takes);
    EXPECT_GT(seen.least, 0.5) << step_takes;
    EXPECT_LT(seen.most, Playback::kSpeed + 1e-6) << step_takes;
    EXPECT_LT(seen.latest, 1.1 * step_takes + 2.0 / 60) << step_takes;
  }
}

}  // namespace
}  // namespace fracture::app
