// The game with a server that is away, busy or slow, or answers nonsense: it reports the problem and goes on.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <condition_variable>
#include <mutex>

#include "tests/client/falling_box.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::game {
namespace {

using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;
using test::falling_box;
using test::glb;
using test::kFrame;
using test::settings_for;

void frames(Game& game, int count) {
  for (int k = 0; k < count; ++k) game.advance(kFrame, true);
}
/// Runs frames until the game has seen the end of an answer, good or bad.
void frames_until(Game& game, const std::function<bool()>& done) {
  test::require_eventually(test::kPatience, "the answer in a frame", [&] {
    if (done()) return true;
    game.advance(kFrame, true);
    return false;
  });
}

TEST(GameFaults, TheFrameDoesNotWaitForASlowServer) {
  std::mutex mutex;
  std::condition_variable wake;
  bool answer = false;
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    std::unique_lock lock(mutex);
    EXPECT_TRUE(wake.wait_for(lock, test::kPatience, [&] { return answer; }));
    return glb(bytes);
  });
  protocol::Client client(settings_for(server));
  Game game(falling_box(), client, {});
  frames_until(game, [&] { return game.figures().requests == 1; });
  const std::uint64_t steps = game.world().steps();
  frames(game, 120);  // two seconds of the game pass, whatever the server does
  EXPECT_EQ(game.world().steps(), steps + 240);
  EXPECT_TRUE(game.world().is_whole(0));
  EXPECT_EQ(game.open_requests(), 1u);
  {
    const std::lock_guard lock(mutex);
    answer = true;
  }
  wake.notify_all();
  frames_until(game, [&] { return game.figures().swaps == 1; });
  EXPECT_FALSE(game.world().is_whole(0));
}

// Three copies of the box in one place: pairs have 6 m³ in common, but the three together fill 2 m³.
TEST(GameMasses, AreThoseOfTheVolumeWithOverlapsCountedOnce) {
  FakeServer server([](const FakeRequest& request) {
    if (request.method != "PUT") return FakeReply{.bytes = {}, .silent = true};
    return FakeReply::answer(
        201, R"({"report": {"solid": {"volume": 6}, "contacts": {"volume": 6}, "volume_once": 3}})");
  });
  protocol::Client client(settings_for(server));
  GameSettings settings;
  const auto history = std::make_shared<History>(nlohmann::json::object());
  settings.history = history;
  Game game(falling_box(), client, settings);
  const auto masses = [&] {
    std::vector<RecordedEvent> events = history->until(history->steps()).events;
    std::erase_if(events, [](const RecordedEvent& e) { return e.kind != RecordedEvent::Kind::kMass; });
    return events;
  };
  frames_until(game, [&] { return !masses().empty(); });
  ASSERT_EQ(masses().size(), 1u);
  EXPECT_NEAR(masses()[0].factor, 1.5, 1e-6) << "the box has 2 m³";
}

TEST(GameFaults, AReproducibleRunStandsStillInstead) {
  std::atomic<bool> answer = false;
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    test::require_eventually(test::kPatience, "the test to let the server answer",
                             [&] { return answer.load(); });
    return glb(bytes);
  });
  protocol::Client client(settings_for(server));
  GameSettings settings;
  settings.fixed_latency = 6;
  settings.anticipate = false;  // an anticipated answer would wait for the hit
  Game game(falling_box(), client, settings);
  test::require_eventually(test::kPatience, "the mesh to be stored", [&] { return game.ready(); });
  while (game.ready() && game.figures().requests == 0) game.step();
  const std::uint64_t asked = game.world().steps();
  while (game.ready()) game.step();
  EXPECT_EQ(game.world().steps(), asked + 6);
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(game.ready());
  answer = true;
  test::require_eventually(test::kPatience, "the answer of the step", [&] { return game.ready(); });
  game.step();
  EXPECT_EQ(game.figures().swaps, 1u);
  ASSERT_EQ(game.swaps().size(), 1u);
  EXPECT_EQ(game.swaps()[0].step, asked + 6);
}

TEST(GameFaults, WithoutAServerThingsStayWholeAndTheGameGoesOn) {
  std::uint16_t port;
  {
    FakeServer gone([](const FakeRequest&) { return FakeReply{}; });
    port = gone.port();
  }
  protocol::Settings s;
  s.port = port;
  s.heartbeat = protocol::Milliseconds(0);
  s.first_pause = protocol::Milliseconds(1);
  s.patience = protocol::Milliseconds(10);
  protocol::Client client(s);
  Game game(falling_box(), client, {});
  frames_until(game, [&] { return game.figures().failures >= 1; });
  EXPECT_TRUE(game.world().is_whole(0));
  EXPECT_NE(game.figures().last_trouble.find("server-absent"), std::string::npos)
      << game.figures().last_trouble;
  const std::uint64_t steps = game.world().steps();
  frames(game, 10);
  EXPECT_EQ(game.world().steps(), steps + 20);
}

TEST(GameFaults, AfterAFailureTheNextHitAsksAgain) {
  std::atomic<int> asked = 0;
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    return ++asked == 1 ? FakeReply::answer(400, R"({"type": "/problems/bad-parameter", "detail": "No."})")
                        : glb(bytes);
  });
  protocol::Client client(settings_for(server));
  Game game(falling_box(), client, {});
  frames_until(game, [&] { return game.figures().failures == 1; });
  EXPECT_TRUE(game.world().is_whole(0));
  game.throw_ball({0.5, 0.5, 4}, {0, 1, -40});
  frames_until(game, [&] { return game.figures().swaps == 1; });
  EXPECT_FALSE(game.world().is_whole(0));
}

class BadAnswers : public testing::TestWithParam<int> {};

TEST_P(BadAnswers, AreReportedAndTheGameGoesOn) {
  test::GlbParts parts = test::two_cubes_glb();
  const float nan = NAN;
  switch (GetParam()) {
    case 0:
      parts.binary.replace(8, 4, reinterpret_cast<const char*>(&nan), 4);
      break;
    case 1:
      parts.json["nodes"][0]["extras"]["fracture"]["bonds"]["b"] = {123456};
      break;
    case 2:
      parts.json["meshes"][0]["primitives"][0]["indices"] = 77;
      break;
    default:
      parts.json = {{"asset", {{"version", "2.0"}}}};
      break;
  }
  const std::string bytes = GetParam() == 4 ? std::string("this is no glTF") : parts.bytes();
  FakeServer server([&](const FakeRequest& request) {
    return request.method == "PUT" ? FakeReply::answer(201, "{}") : glb(bytes);
  });
  protocol::Client client(settings_for(server));
  Game game(falling_box(), client, {});
  frames_until(game, [&] { return game.figures().failures >= 1; });
  EXPECT_NE(game.figures().last_trouble.find("cannot be used"), std::string::npos)
      << game.figures().last_trouble;
  EXPECT_TRUE(game.world().is_whole(0));
  const std::uint64_t steps = game.world().steps();
  frames(game, 10);
  EXPECT_EQ(game.world().steps(), steps + 20);
}

INSTANTIATE_TEST_SUITE_P(All, BadAnswers, testing::Range(0, 5));

TEST(GameFaults, BusyAndDamagedAnswersAreOvercome) {
  const std::string bytes = test::two_cubes_glb().bytes();
  std::atomic<int> asked = 0;
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    FakeReply reply = glb(bytes);
    switch (asked++) {
      case 0:
        return FakeReply::answer(503, "{}", "Retry-After: 0\r\n");
      case 1:
        reply.bytes[reply.bytes.size() / 2] ^= 1;
        break;  // one bit differs
      case 2:
        reply = {reply.bytes.substr(0, reply.bytes.size() / 2), true};
        break;  // cut off
      default:
        break;
    }
    return reply;
  });
  protocol::Client client(settings_for(server));
  Game game(falling_box(), client, {});
  frames_until(game, [&] { return game.figures().swaps == 1; });
  EXPECT_EQ(game.figures().failures, 0u);
  EXPECT_EQ(client.status().retried, 3u);
}

TEST(GameFaults, AStormOfBusyAnswersEndsInFragments) {
  const std::string bytes = test::two_cubes_glb().bytes();
  constexpr int kStorm = 40;
  std::atomic<int> asked = 0;
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    return asked++ < kStorm ? FakeReply::answer(503, "{}", "Retry-After: 0\r\n") : glb(bytes);
  });
  protocol::Settings settings = settings_for(server);
  settings.patience = std::chrono::minutes(10);
  protocol::Client client(settings);
  Game game(falling_box(), client, {});
  std::uint64_t frames_before = game.world().steps();
  frames_until(game, [&] { return game.figures().swaps == 1; });
  EXPECT_GT(game.world().steps(), frames_before);  // the game went on meanwhile
  EXPECT_EQ(client.status().retried, static_cast<std::uint64_t>(kStorm));
  EXPECT_EQ(game.figures().failures, 0u);
}

TEST(GameFaults, AServerThatForgotTheMeshGetsItAgain) {
  const std::string bytes = test::two_cubes_glb().bytes();
  std::atomic<int> puts = 0, asked = 0;
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") {
      ++puts;
      return FakeReply::answer(201, "{}");
    }
    // This request may arrive before the mesh does, which gets the same answer.
    return asked++ == 0 ? FakeReply::answer(404, R"({"type": "/problems/not-found", "detail": "?"})")
                        : glb(bytes);
  });
  protocol::Client client(settings_for(server));
  Game game(falling_box(), client, {});
  frames_until(game, [&] { return game.figures().swaps == 1; });
  EXPECT_EQ(puts, 2);
}

TEST(GameFaults, AnAnswerForAGameThatEndedIsIgnored) {
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    return request.method == "PUT" ? FakeReply::answer(201, "{}") : glb(bytes);
  });
  protocol::Client client(settings_for(server));
  {
    Game first(falling_box(), client, {});
    frames_until(first, [&] { return first.figures().requests == 1; });
  }
  Game second(falling_box(), client, {});
  frames_until(second, [&] { return second.figures().swaps == 1; });
  EXPECT_EQ(second.figures().answers, 1u);
}

TEST(GameFaults, TwoHundredGamesLeaveNothingBehind) {
  const std::string bytes = test::two_cubes_glb().bytes();
  FakeServer server([&](const FakeRequest& request) {
    return request.method == "PUT" ? FakeReply::answer(201, "{}") : glb(bytes);
  });
  protocol::Client client(settings_for(server));
  GameSettings settings;
  settings.fixed_latency = 2;
  std::optional<std::uint64_t> fingerprint;
  const auto in_use = [] {
    return static_cast<std::ptrdiff_t>(::mallinfo2().uordblks);
  };  // bytes in all threads
  std::ptrdiff_t early = 0;
  for (int k = 0; k < 200; ++k) {
    if (k == 40) early = in_use();
    Game game(falling_box(), client, settings);
    while (game.figures().swaps == 0) {
      test::require_eventually(test::kPatience, "the answer of the step", [&] { return game.ready(); });
      game.step();
    }
    if (!fingerprint) fingerprint = game.world().fingerprint();
    ASSERT_EQ(game.world().fingerprint(), *fingerprint) << k;
  }
  test::require_eventually(test::kPatience, "the requests to end", [&] { return client.status().open == 0; });
  const std::ptrdiff_t late = in_use();
  std::ptrdiff_t noted = 0;  // kept by the fake server, which stores every request
  for (const FakeRequest& request : server.requests())
    noted += static_cast<std::ptrdiff_t>(request.method.capacity() + request.target.capacity() +
                                         request.head.capacity() + request.body.capacity());
  // 160 more cycles: if each left an answer (6 KB) behind, that would be a megabyte.
  EXPECT_LT(late - early, noted + 300'000);
}

}  // namespace
}  // namespace fracture::game
