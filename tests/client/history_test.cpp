// A game's history: it can be saved, continued, and rewound.
#include "client/game/history.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "client/game/moment.hpp"
#include "tests/client/recorded_game.hpp"

namespace fracture::game {
namespace {

using test::FakeRequest;
using test::FakeServer;

class Histories : public Recordings {
 protected:
  /// Plays steps of a reproducible game, with a ball at one of them.
  static void play_steps(Game& game, std::uint64_t until) {
    constexpr std::uint64_t kThrown = 40;
    while (game.world().steps() < until) {
      test::require_eventually(test::kPatience, "the answers of the step", [&] { return game.ready(); });
      if (game.world().steps() == kThrown) game.throw_ball({0.5, 0.5, 4}, {0.1, 1.0 / 3, -20});
      game.step();
    }
  }
  /// Eight boxes, of which only two may be requested at a time, so hits wait.
  static scenes::Scene many_boxes() {
    scenes::Scene boxes = scene();
    for (int k = 4; k < 8; ++k) {
      boxes.objects.push_back(boxes.objects[0]);
      boxes.objects.back().pose.position = {3.0 * k, 1.5 + 0.02 * k, 0};
    }
    boxes.throws = {{0.4, {3.5, 0.5, 4}, {0, 1, -20}}, {0.8, {6.5, 0.5, 4}, {0, 1, -20}}};
    return boxes;
  }
  GameSettings reproducible(const std::string& log) const {
    GameSettings settings;
    settings.max_requests = 2;
    settings.fixed_latency = 6;
    settings.recorder = std::make_shared<Recorder>(*Recorder::create(log, {{"scene", "boxes"}}));
    return settings;
  }
  static std::string text_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

TEST_F(Histories, AnyStepIsReachedAgainWithoutAServer) {
  GameSettings settings;
  settings.history = std::make_shared<History>(nlohmann::json{{"scene", "boxes"}});
  settings.answers = std::make_shared<KeptAnswers>();
  const std::uint64_t last = play(settings);
  const Recording all = settings.history->until(settings.history->steps());
  ASSERT_GT(all.hashes.size(), 200u);
  EXPECT_EQ(all.hashes.back(), last);
  std::uint16_t nobody;
  {
    FakeServer gone([](const FakeRequest&) { return test::FakeReply{}; });
    nobody = gone.port();
  }
  protocol::Settings absent;
  absent.port = nobody;
  absent.patience = protocol::Milliseconds(10);
  protocol::Client client(absent);
  std::uint64_t adopted = 0;
  for (const RecordedEvent& event : all.events)
    if (event.kind == RecordedEvent::Kind::kAdopt) adopted = std::max(adopted, event.step);
  ASSERT_GT(adopted, 0u);
  for (const std::uint64_t step : {std::uint64_t{1}, adopted, adopted + 1, all.hashes.size()}) {
    GameSettings again = replaying(settings.history->until(step));
    again.answers = settings.answers;
    Game game(scene(), client, again);
    play_again(game);
    ASSERT_FALSE(game.figures().diverged) << step << ": " << *game.figures().diverged;
    ASSERT_EQ(game.world().steps(), step);
    EXPECT_EQ(game.world().fingerprint(), all.hashes[step - 1]) << step;
    // The game continues from there.
    game.hand_over();
    game.throw_ball({0.5, 0.5, 4}, {0, 1, -20});
    for (int k = 0; k < 10; ++k) game.advance(test::kFrame, true);
    EXPECT_GE(game.world().steps(), step + 10);  // a frame that swaps has only one step
  }
}

TEST_F(Histories, AGameThatIsGoneOnWithIsTheOneThatWasNeverInterrupted) {
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  constexpr std::uint64_t kAll = 240;
  std::uint64_t fingerprint;
  {
    Game whole(many_boxes(), client, reproducible(folder_ / "whole.jsonl"));
    play_steps(whole, kAll);
    EXPECT_GT(whole.figures().swaps, 4u);
    fingerprint = whole.world().fingerprint();
  }
  // Before the first request, while hits wait, between the balls that the scene throws, and at the end.
  for (const std::uint64_t stopped : {1u, 30u, 75u, 76u, 239u, 240u}) {
    const std::string first = folder_ / "first.jsonl", second = folder_ / "second.jsonl";
    {
      Game begun(many_boxes(), client, reproducible(first));
      play_steps(begun, stopped);
    }
    const Expected<Recording> recording = read_recording(first);
    ASSERT_TRUE(recording) << recording.error().detail;
    ASSERT_EQ(recording->hashes.size(), stopped);
    {
      GameSettings settings = reproducible(second);
      settings.replay = std::make_shared<const Recording>(*recording);
      Game game(many_boxes(), client, settings);
      play_again(game);
      ASSERT_FALSE(game.figures().diverged) << stopped << ": " << *game.figures().diverged;
      game.hand_over();
      play_steps(game, kAll);
      EXPECT_EQ(game.world().fingerprint(), fingerprint) << stopped;
    }
    EXPECT_EQ(text_of(second), text_of(folder_ / "whole.jsonl")) << stopped;
  }
}

TEST_F(Histories, WhatFailedFailsAgainWhateverTheServerSays) {
  GameSettings settings;
  settings.history = std::make_shared<History>(nlohmann::json{{"scene", "boxes"}});
  const std::uint64_t last = play(settings);
  FakeServer willing([this](const FakeRequest& request) {
    return request.method == "PUT" ? test::FakeReply::answer(201, "{}") : test::glb(bytes_);
  });
  protocol::Client client(test::settings_for(willing));
  Game game(scene(), client, replaying(settings.history->until(settings.history->steps())));
  play_again(game);
  EXPECT_FALSE(game.figures().diverged);
  EXPECT_EQ(game.world().fingerprint(), last);
}

TEST_F(Histories, AWrittenHistoryIsTheRecordingOfTheSameGame) {
  GameSettings settings;
  settings.history = std::make_shared<History>(nlohmann::json{{"scene", "boxes"}});
  settings.recorder =
      std::make_shared<Recorder>(*Recorder::create(folder_ / "a.jsonl", {{"scene", "boxes"}}));
  play(settings);
  ASSERT_TRUE(settings.recorder->finish());
  const auto written =
      write_recording(folder_ / "b.jsonl", settings.history->until(settings.history->steps()));
  ASSERT_TRUE(written) << written.error().detail;
  const Expected<Recording> a = read_recording(folder_ / "a.jsonl"), b = read_recording(folder_ / "b.jsonl");
  ASSERT_TRUE(a);
  ASSERT_TRUE(b);
  EXPECT_EQ(a->header, b->header);
  EXPECT_EQ(a->hashes, b->hashes);
  ASSERT_EQ(a->events.size(), b->events.size());
  for (std::size_t k = 0; k < a->events.size(); ++k) EXPECT_EQ(line_of(a->events[k]), line_of(b->events[k]));
  EXPECT_FALSE(write_recording(folder_ / "none/b.jsonl", *b));
}

TEST_F(Histories, AFullOneKeepsItsBeginning) {
  constexpr std::size_t kSteps = 50;
  GameSettings settings;
  settings.history = std::make_shared<History>(nlohmann::json::object(), kSteps * sizeof(std::uint64_t));
  settings.max_requests = 0;
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  scenes::Scene high = scene();
  for (scenes::SceneObject& object : high.objects) object.pose.position.y = 50;  // too high to hit the ground
  Game game(std::move(high), client, settings);
  while (game.world().steps() < 2 * kSteps) game.step();
  EXPECT_TRUE(settings.history->full());
  EXPECT_EQ(settings.history->steps(), kSteps);
  EXPECT_EQ(settings.history->until(2 * kSteps).hashes.size(), kSteps);
}

TEST_F(Histories, ThePastIsBoundedAndFoundByStep) {
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  Game game(scene(), client, {});
  Past few(20), small(1000, 3 * moment_of(game).bytes());
  EXPECT_EQ(few.at(0), nullptr);
  for (int k = 0; k < 40; ++k) {
    game.step();
    const auto moment = std::make_shared<const Moment>(moment_of(game));
    few.add(moment);
    few.add(moment);  // the same step counts once
    small.add(moment);
  }
  EXPECT_EQ(few.size(), 21u);
  EXPECT_EQ(few.at(30)->step, 30u);
  EXPECT_EQ(few.at(1)->step, 20u);  // the oldest one
  EXPECT_EQ(small.size(), 3u);
  const world::Pose now = game.world().object_pose(0);
  EXPECT_EQ(few.at(40)->parts[0].whole.position, now.position);
  EXPECT_GT(few.at(30)->parts[0].whole.position.y, now.position.y);
  few.clear();
  EXPECT_EQ(few.at(40), nullptr);
}

}  // namespace
}  // namespace fracture::game
