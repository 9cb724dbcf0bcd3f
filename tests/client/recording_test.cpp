#include "client/game/recording.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/client/falling_box.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::game {
namespace {

using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;
using test::kFrame;

class Recordings : public testing::Test {
 protected:
  /// Four boxes, of which the server leaves the second whole.
  static scenes::Scene scene() {
    scenes::Scene scene = test::falling_box();
    for (int k = 1; k < 4; ++k) {
      scene.objects.push_back(scene.objects[0]);
      scene.objects.back().pose.position.x = 3 * k;
    }
    return scene;
  }
  FakeReply answer(const FakeRequest& request) const {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    // By what is asked, for two connections have no order: the second request of the game.
    if (nlohmann::json::parse(request.body).value("seed", 0) == 3)
      return FakeReply::answer(400, R"({"type": "/problems/bad-parameter", "detail": "No."})");
    return test::glb(bytes_);
  }

  /// Plays in real time, as fast as it goes, and records. Returns the last fingerprint.
  std::uint64_t play(const std::string& path) {
    FakeServer server([this](const FakeRequest& request) { return answer(request); });
    protocol::Client client(test::settings_for(server));
    GameSettings settings;
    settings.max_requests = 2;
    settings.recorder = std::make_shared<Recorder>(*Recorder::create(path, {{"scene", "boxes"}}));
    Game game(scene(), client, settings);
    int frame = 0;
    test::require_eventually(test::kPatience, "all answers", [&] {
      if (frame == 20) game.throw_ball({0.5, 0.5, 4}, {0.1, 1.0 / 3, -20});
      if (frame == 50) game.set_overrides({{"sites", 12}});
      game.set_eye({0.1 * frame, 1, 5});
      game.advance(kFrame, true);
      return ++frame > 150 && game.figures().swaps >= 3 &&
             game.open_requests() + game.waiting_requests() == 0;
    });
    EXPECT_GE(game.figures().failures, 1u);
    return game.world().fingerprint();
  }

  /// Plays it again until it ends or differs.
  static void play_again(Game& game) {
    while (!game.replayed() && !game.figures().diverged) {
      test::require_eventually(test::kPatience, "the answers of the step", [&] { return game.ready(); });
      game.step();
    }
  }
  static GameSettings replaying(const Recording& recording) {
    GameSettings settings;
    settings.max_requests = 2;
    settings.replay = std::make_shared<const Recording>(recording);
    return settings;
  }

  test::TemporaryFolder folder_;
  const std::string bytes_ = test::two_cubes_glb().bytes();
};

TEST_F(Recordings, PlayedAgainGiveTheSameBits) {
  const std::string path = folder_ / "game.jsonl";
  const std::uint64_t fingerprint = play(path);
  const Expected<Recording> recording = read_recording(path);
  ASSERT_TRUE(recording) << recording.error().detail;
  EXPECT_EQ(recording->header["scene"], "boxes");
  EXPECT_GT(recording->hashes.size(), 200u);
  EXPECT_EQ(recording->hashes.back(), fingerprint);
  // A server that takes other times.
  FakeServer slow([this](const FakeRequest& request) {
    // pause: the answers come in other steps than they did
    std::this_thread::sleep_for(std::chrono::milliseconds(request.number % 2 == 0 ? 30 : 1));
    return answer(request);
  });
  protocol::Client client(test::settings_for(slow));
  Game game(scene(), client, replaying(*recording));
  play_again(game);
  EXPECT_FALSE(game.figures().diverged) << *game.figures().diverged;
  EXPECT_EQ(game.world().fingerprint(), fingerprint);
}

TEST_F(Recordings, TheFirstStepThatDiffersIsNamed) {
  const std::string path = folder_ / "game.jsonl";
  play(path);
  Expected<Recording> recording = read_recording(path);
  ASSERT_TRUE(recording) << recording.error().detail;
  std::uint64_t thrown = 0;
  for (RecordedEvent& event : recording->events)
    if (event.kind == RecordedEvent::Kind::kThrow) {
      event.velocity.x += 1e-9;
      thrown = event.step;
    }
  ASSERT_GT(thrown, 0u);
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  Game game(scene(), client, replaying(*recording));
  play_again(game);
  ASSERT_TRUE(game.figures().diverged);
  EXPECT_EQ(*game.figures().diverged, thrown);
}

TEST_F(Recordings, WhatIsNoRecordingIsRefusedWithItsLine) {
  const auto detail = [&](const std::string& text) {
    const std::string path = folder_.write("bad.jsonl", text);
    const Expected<Recording> recording = read_recording(path);
    return recording ? std::string() : recording.error().detail;
  };
  const std::string header = R"({"format": "fracture-game-1"})";
  EXPECT_NE(detail("").find("empty"), std::string::npos);
  EXPECT_NE(detail("{}").find("line 1"), std::string::npos);
  EXPECT_NE(detail(R"({"format": "other"})").find("another format"), std::string::npos);
  EXPECT_NE(detail(header + "\n{\"step\": 0, \"throw\": [[1, 2], [0, 0, 0]]}\n").find("line 2"),
            std::string::npos);
  EXPECT_NE(detail(header + "\n{\"step\": 1, \"hash\": \"00\"}\n").find("not the next"), std::string::npos);
  EXPECT_NE(detail(header + "\n{\"step\": 0, \"hash\": \"00\"}\n{\"step\": 1, \"ha").find("line 3"),
            std::string::npos);
  EXPECT_NE(read_recording(folder_ / "nowhere").error().detail.find("nowhere"), std::string::npos);
}

}  // namespace
}  // namespace fracture::game
