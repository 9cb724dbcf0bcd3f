// A game of four falling boxes that is recorded and replayed, with a fake server in the test.
#pragma once

#include <gtest/gtest.h>

#include "tests/client/falling_box.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::game {

class Recordings : public testing::Test {
 protected:
  /// Four boxes. The server leaves the second one whole.
  static scenes::Scene scene() {
    scenes::Scene scene = test::falling_box();
    for (int k = 1; k < 4; ++k) {
      scene.objects.push_back(scene.objects[0]);
      scene.objects.back().pose.position.x = 3 * k;
    }
    return scene;
  }
  test::FakeReply answer(const test::FakeRequest& request) const {
    if (request.method == "PUT") return test::FakeReply::answer(201, "{}");
    // Chosen by the request's content, because two connections have no order: the second request of the game
    // is refused.
    if (nlohmann::json::parse(request.body).value("seed", 0) == 3)
      return test::FakeReply::answer(400, R"({"type": "/problems/bad-parameter", "detail": "No."})");
    return test::glb(bytes_);
  }

  std::uint64_t play(const std::string& path) {
    GameSettings settings;
    settings.recorder = std::make_shared<Recorder>(*Recorder::create(path, {{"scene", "boxes"}}));
    return play(std::move(settings));
  }

  /// Plays in real time as fast as possible, and records. Returns the last fingerprint.
  std::uint64_t play(GameSettings settings) {
    test::FakeServer server([this](const test::FakeRequest& request) { return answer(request); });
    protocol::Client client(test::settings_for(server));
    settings.max_requests = 2;
    Game game(scene(), client, settings);
    int frame = 0;
    test::require_eventually(test::kPatience, "all answers", [&] {
      if (frame == 20) game.throw_ball({0.5, 0.5, 4}, {0.1, 1.0 / 3, -20});
      if (frame == 50) game.set_overrides({{"sites", 12}});
      game.set_eye({0.1 * frame, 1, 5});
      game.advance(test::kFrame, true);
      return ++frame > 150 && game.figures().swaps >= 3 &&
             game.open_requests() + game.waiting_requests() == 0;
    });
    EXPECT_GE(game.figures().failures, 1u);
    return game.world().fingerprint();
  }

  /// Replays the game until it ends or differs.
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

}  // namespace fracture::game
