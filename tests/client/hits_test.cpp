// The game requests the change of a further hit in advance, and replaces the old fragments with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "client/game/history.hpp"
#include "tests/client/falling_box.hpp"
#include "tests/server/support/temporary_folder.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::game {
namespace {

using nlohmann::json;
using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;
using test::kFrame;

constexpr const char* kFirst = "/fractures/sha256:aa";
constexpr const char* kSecond = "/fractures/sha256:bb";

FakeReply at(const std::string& bytes, const char* location) {
  return FakeReply::answer(200, bytes,
                           test::digest_field(bytes) + "Content-Location: " + std::string(location) + "\r\n");
}

/// A box that is held by its left half and withstands every ball. It breaks into two cubes; hits on the right
/// one make slabs.
class Hits : public testing::Test {
 protected:
  static scenes::Scene scene() {
    scenes::Scene scene = test::falling_box();
    scene.objects[0].held = true;
    scene.objects[0].pose.position = {0, 0.6, 0};
    scene.objects[0].breakage.parameters = {{"material", "stone"}};
    return scene;
  }
  static GameSettings settings() {
    GameSettings settings;
    settings.fixed_latency = 6;
    return settings;
  }
  static test::GlbParts sound(test::GlbParts parts) {
    for (json& strength : parts.json["nodes"][0]["extras"]["fracture"]["bonds"]["strength"]) strength = 1e12;
    return parts;
  }
  FakeReply answer(const FakeRequest& request) const {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    return json::parse(request.body).contains("local_point") ? at(halved_, kSecond) : at(two_, kFirst);
  }
  static std::vector<json> bodies(const FakeServer& server) {
    std::vector<json> result;
    for (const FakeRequest& request : server.requests())
      if (request.method == "POST") result.push_back(json::parse(request.body));
    return result;
  }
  static void steps(Game& game, int count) {
    for (int k = 0; k < count; ++k) {
      test::require_eventually(test::kPatience, "the answers of the step", [&] { return game.ready(); });
      game.step();
    }
  }
  /// Throws a ball at the left cube, which breaks the whole box.
  static void break_whole(Game& game) {
    game.throw_ball({0, 0.7, 4}, {0, 0.5, -20});
    steps(game, 60);
    ASSERT_FALSE(game.world().is_whole(0));
  }
  /// Throws a ball at the right cube.
  static void hit(Game& game) {
    game.throw_ball({1, 0.7, 6}, {0, 0.5, -20});
    steps(game, 60);
  }
  static std::vector<std::uint64_t> present(const Game& game) {
    std::vector<world::FragmentState> states;
    game.world().fragment_states(0, states);
    const world::FragmentSet& set = world::fragments_of(*game.things()[0].fragments->fragments);
    std::vector<std::uint64_t> ids;
    for (std::size_t k = 0; k < states.size(); ++k)
      if (states[k].present) ids.push_back(set.fragments[k].id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }

  const std::string two_ = sound(test::two_cubes_glb()).bytes(),
                    halved_ = sound(test::halved_cube_glb()).bytes();
};

TEST_F(Hits, AskForWhatTheyChangeOfTheAnswerAndHaveItInTime) {
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  Game game(scene(), client, settings());
  break_whole(game);
  ASSERT_EQ(bodies(server).size(), 1u) << "the hit that breaks the whole has its fragments";
  EXPECT_EQ(bodies(server)[0].at("delta"), "stated") << "the server keeps what the first hit starts from";
  game.throw_ball({1, 0.7, 6}, {0, 0.5, -20});
  while (game.figures().hits == 0) {
    steps(game, 1);
    ASSERT_LT(game.world().steps(), 120u);
  }
  EXPECT_GT(game.world().balls().back().pose.position.z, 1) << "the ball is not there yet";
  EXPECT_EQ(present(game), (std::vector<std::uint64_t>{7, 11, 12}));
  const std::vector<json> asked = bodies(server);
  ASSERT_EQ(asked.size(), 2u);
  EXPECT_EQ(asked[1].at("of"), kFirst);
  EXPECT_EQ(asked[1].at("delta"), "only");
  EXPECT_FALSE(asked[1].contains("material")) << "that is decided";
  const json point = asked[1].at("local_point").at(0);
  EXPECT_NEAR(point[0].get<double>(), 1, 0.05);
  EXPECT_NEAR(point[2].get<double>(), 0.5, 0.05);
  EXPECT_EQ(game.figures().too_late, 0u);
  EXPECT_LT(game.figures().worst_momentum_error, 1e-9);
  // The next request refers to the answer of this one.
  hit(game);
  ASSERT_EQ(bodies(server).size(), 2u) << "the ball has been asked for";
  hit(game);
  ASSERT_GE(bodies(server).size(), 3u);
  EXPECT_EQ(bodies(server)[2].at("of"), kSecond);
}

TEST_F(Hits, ArePlayedAgainWithTheAnswersThatWereKept) {
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  GameSettings first = settings();
  first.history = std::make_shared<History>(json{{"scene", "box"}});
  first.answers = std::make_shared<KeptAnswers>();
  {
    Game game(scene(), client, first);
    break_whole(game);
    hit(game);
    ASSERT_EQ(game.figures().hits, 1u);
  }
  const std::size_t asked = bodies(server).size();
  const Recording all = first.history->until(first.history->steps());
  for (int twice = 0; twice < 2; ++twice) {
    GameSettings again;
    again.answers = first.answers;
    again.replay = std::make_shared<const Recording>(all);
    Game game(scene(), client, again);
    while (!game.replayed() && !game.figures().diverged) steps(game, 1);
    ASSERT_FALSE(game.figures().diverged) << *game.figures().diverged;
    EXPECT_EQ(game.world().fingerprint(), all.hashes.back());
    EXPECT_EQ(game.figures().hits, 1u);
    EXPECT_EQ(bodies(server).size(), asked);
  }
  // A change is kept for the fragments that it changes. Other fragments with the same bytes do not match.
  const auto other = std::make_shared<const Decoded>();
  json wanted = json::parse(R"({"sites": 2})");
  first.answers->keep("mesh", wanted, {std::make_shared<const Decoded>(decode(1, two_)), other});
  EXPECT_NE(first.answers->find("mesh", wanted, other), nullptr);
  EXPECT_EQ(first.answers->find("mesh", wanted, std::make_shared<const Decoded>()), nullptr);
  EXPECT_EQ(first.answers->find("mesh", wanted), nullptr);
}

TEST_F(Hits, OnAnAnswerThatTheServerHasForgottenAskByItsParameters) {
  FakeServer server([this](const FakeRequest& request) {
    if (request.method == "POST" && json::parse(request.body).contains("of"))
      return FakeReply::answer(404, R"({"type": "/problems/no-such-answer", "detail": "?"})");
    return answer(request);
  });
  protocol::Client client(test::settings_for(server));
  Game game(scene(), client, settings());
  break_whole(game);
  hit(game);
  EXPECT_EQ(game.figures().hits, 1u);
  EXPECT_EQ(game.figures().failures, 0u);
  EXPECT_EQ(present(game), (std::vector<std::uint64_t>{7, 11, 12}));
  const std::vector<json> asked = bodies(server);
  ASSERT_EQ(asked.size(), 3u);
  json expected = asked[0];
  for (const char* key : {"local_point", "local_radius", "local_sites"}) expected[key] = asked[1].at(key);
  expected.update({{"local_rest", "fractured"}, {"delta", "only"}, {"local_new", 1}});
  EXPECT_EQ(asked[2], expected);
}

TEST_F(Hits, WhoseAnswersCannotBeUsedLeaveWhatWasThere) {
  for (const bool refused : {true, false}) {
    test::GlbParts parts = test::halved_cube_glb();
    parts.json["nodes"][0]["extras"]["fracture"]["delta"]["gone"] = {77};
    const std::string wrong = parts.bytes();
    FakeServer server([&](const FakeRequest& request) {
      if (request.method != "POST" || !json::parse(request.body).contains("of")) return answer(request);
      return refused ? FakeReply::answer(400, R"({"type": "/problems/bad-parameter", "detail": "No."})")
                     : at(wrong, kSecond);
    });
    protocol::Client client(test::settings_for(server));
    Game game(scene(), client, settings());
    break_whole(game);
    hit(game);
    EXPECT_EQ(game.figures().failures, 1u) << "once for a ball";
    EXPECT_NE(game.figures().last_trouble.find(refused ? "No." : "77"), std::string::npos)
        << game.figures().last_trouble;
    EXPECT_EQ(present(game), (std::vector<std::uint64_t>{7, 9}));
  }
}

TEST_F(Hits, OnFragmentsThatAreThereFromTheStartAskForNothing) {
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  scenes::Scene bricks = scene();
  bricks.objects[0].at_start = true;
  Game game(std::move(bricks), client, settings());
  steps(game, 10);
  ASSERT_FALSE(game.world().is_whole(0));
  hit(game);
  EXPECT_EQ(bodies(server).size(), 1u);
}

TEST_F(Hits, AreNotExpectedByWhatFallsNorByWhatIsBrokenFromTheStart) {
  FakeServer server([this](const FakeRequest& request) { return answer(request); });
  protocol::Client client(test::settings_for(server));
  scenes::Scene falling = test::falling_box(), bricks = scene(), levels = scene();
  bricks.objects[0].at_start = true;
  levels.objects[0].breakage.parameters["levels"] = {4, 2};
  for (scenes::Scene* one : {&falling, &bricks, &levels}) {
    const std::size_t before = bodies(server).size();
    Game game(std::move(*one), client, settings());
    if (one == &levels) game.throw_ball({0, 0.7, 4}, {0, 0.5, -20});
    steps(game, 60);
    ASSERT_GT(bodies(server).size(), before);
    EXPECT_FALSE(bodies(server)[before].contains("delta"));
  }
}

TEST_F(Hits, AreReadTogetherWithTheAnswerBefore) {
  const Decoded whole = decode(1, two_);
  ASSERT_TRUE(whole.fragments) << whole.error;
  const Decoded after = decode(2, halved_, std::make_shared<const Decoded>(whole));
  ASSERT_TRUE(after.fragments) << after.error;
  EXPECT_EQ(world::fragments_of(*after.fragments).fragments.size(), 4u);
  ASSERT_EQ(after.layers.size(), 2u);
  EXPECT_EQ(after.layers[0].fragment_of_object, (std::vector<std::uint32_t>{0, Decoded::kNoFragment}));
  EXPECT_EQ(after.layers[1].fragment_of_object, (std::vector<std::uint32_t>{2, 3}));
  EXPECT_EQ(after.layers[0].model, whole.layers[0].model) << "it is on the graphics card already";
  // A whole answer is not accepted as a change, nor a change as a whole answer.
  EXPECT_NE(decode(3, two_, std::make_shared<const Decoded>(whole)).error.find("delta"), std::string::npos);
  EXPECT_NE(decode(4, halved_).error.find("7"), std::string::npos);
}

TEST_F(Hits, ArePlayedAgainToTheSameBits) {
  test::TemporaryFolder folder;
  const std::string path = folder / "game.jsonl";
  std::uint64_t fingerprint = 0;
  {
    FakeServer server([this](const FakeRequest& request) { return answer(request); });
    protocol::Client client(test::settings_for(server));
    GameSettings settings;
    settings.recorder = std::make_shared<Recorder>(*Recorder::create(path, {{"scene", "box"}}));
    Game game(scene(), client, settings);
    int frame = 0;
    test::require_eventually(test::kPatience, "both answers", [&] {
      if (frame == 0) game.throw_ball({0, 0.7, 4}, {0, 0.5, -20});
      if (frame == 60) game.throw_ball({1, 0.7, 6}, {0, 0.5, -20});
      // Time stops until the box is broken and the hit has its answer, so that the answer is in time.
      const bool wait = game.open_requests() > 0;
      game.advance(wait ? 0 : kFrame, true);
      frame += !wait;
      return frame > 120;
    });
    ASSERT_EQ(game.figures().hits, 1u);
    fingerprint = game.world().fingerprint();
  }
  const Expected<Recording> recording = read_recording(path);
  ASSERT_TRUE(recording) << recording.error().detail;
  FakeServer slow([this](const FakeRequest& request) {
    // pause: the answers arrive in other steps than before
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return answer(request);
  });
  protocol::Client client(test::settings_for(slow));
  GameSettings settings;
  settings.replay = std::make_shared<const Recording>(*recording);
  Game game(scene(), client, settings);
  while (!game.replayed() && !game.figures().diverged) {
    test::require_eventually(test::kPatience, "the answers of the step", [&] { return game.ready(); });
    game.step();
  }
  EXPECT_FALSE(game.figures().diverged) << *game.figures().diverged;
  EXPECT_EQ(game.figures().hits, 1u);
  EXPECT_EQ(game.world().fingerprint(), fingerprint);
}

}  // namespace
}  // namespace fracture::game
