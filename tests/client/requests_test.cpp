// Which hit is requested if more happen at once than may be open.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/client/falling_box.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::game {
namespace {

using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;
using test::kFrame;

/// A row of `count` falling boxes, 3 m apart.
scenes::Scene boxes(int count) {
  scenes::Scene scene = test::falling_box();
  const scenes::SceneObject one = scene.objects[0];
  scene.objects.clear();
  for (int k = 0; k < count; ++k) {
    scene.objects.push_back(one);
    scene.objects.back().pose.position.x = 3 * k;
  }
  scene.eye = {0, 1, 3};
  return scene;
}

TEST(Requests, TwentyBoxesThatFallTogetherAllBreak) {
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    return request.method == "PUT" ? FakeReply::answer(201, "{}") : test::glb(bytes);
  });
  protocol::Client client(test::settings_for(server));
  GameSettings settings;
  settings.max_requests = 3;
  Game game(boxes(20), client, settings);
  std::size_t most_open = 0, most_waiting = 0;
  test::require_eventually(test::kPatience, "all answers", [&] {
    game.advance(kFrame, true);
    most_open = std::max(most_open, game.open_requests());
    most_waiting = std::max(most_waiting, game.waiting_requests());
    // An anticipated hit is valid only for some steps, so here every answer arrives within its frame.
    test::require_eventually(test::kPatience, "the answers of this frame",
                             [&] { return game.ready() && game.open_requests() == 0; });
    for (world::ObjectId k = 0; k < 20; ++k)
      if (game.world().is_whole(k)) return false;
    return true;
  });
  game.advance(kFrame, true);
  EXPECT_LE(most_open, 3u);
  EXPECT_GT(most_waiting, 10u);
}

TEST(Requests, WhatIsForeseenIsKeptUntilItIsHit) {
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    return request.method == "PUT" ? FakeReply::answer(201, "{}") : test::glb(bytes);
  });
  protocol::Client client(test::settings_for(server));
  GameSettings settings;
  settings.fixed_latency = 6;
  Game game(boxes(1), client, settings);
  std::uint64_t kept_since = 0;
  while (game.world().is_whole(0)) {
    test::require_eventually(test::kPatience, "the answer of the step", [&] { return game.ready(); });
    game.step();
    if (kept_since == 0 && game.kept_answers() == 1) kept_since = game.world().steps();
    ASSERT_LT(game.world().steps(), 1000u);
  }
  // The game looks half a second ahead. The answer arrives after a tenth of that, and takes effect some steps
  // before the hit.
  ASSERT_GT(kept_since, 0u);
  EXPECT_GT(game.world().steps(), kept_since + 24);
  EXPECT_EQ(game.kept_answers(), 0u);
}

TEST(Requests, TheHardestAndNearestHitIsFirst) {
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    return request.method == "PUT" ? FakeReply::answer(201, "{}") : test::glb(bytes);
  });
  protocol::Client client(test::settings_for(server));
  GameSettings settings;
  settings.max_requests = 1;
  settings.fixed_latency = 30;
  // Equal boxes: those near the eye, which is in front of the first one, come first.
  Game game(boxes(5), client, settings);
  std::vector<world::ObjectId> order;
  while (order.size() < 5) {
    test::require_eventually(test::kPatience, "the answer of the step", [&] { return game.ready(); });
    game.step();
    for (world::ObjectId k = 0; k < 5; ++k)
      if (!game.world().is_whole(k) && std::find(order.begin(), order.end(), k) == order.end())
        order.push_back(k);
    ASSERT_LT(game.world().steps(), 1000u);
  }
  EXPECT_EQ(order, (std::vector<world::ObjectId>{0, 1, 2, 3, 4}));
}

}  // namespace
}  // namespace fracture::game
