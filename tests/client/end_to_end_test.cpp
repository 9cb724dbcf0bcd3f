// Scenes against a real server, without a window and reproducible; and the example in another language.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include "client/app/headless.hpp"
#include "client/egl/egl_context.hpp"
#include "client/game/game.hpp"
#include "client/render/image.hpp"
#include "client/scenes/scene.hpp"
#include "client/scenes/solid_shapes.hpp"
#include "tests/client/headless_run.hpp"
#include "tests/server/support/server_process.hpp"
#include "tests/server/support/temporary_folder.hpp"

namespace fracture::app {
namespace {

using nlohmann::json;

render::Picture read_picture(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  auto picture =
      render::decode_picture(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
  if (!picture) throw std::runtime_error(path + ": " + picture.error().detail);
  return *picture;
}

struct SceneCase {
  const char* name;
  double seconds;
  std::size_t fragments;  ///< minimum number
};

class Scenes : public testing::TestWithParam<SceneCase> {};

TEST_P(Scenes, BreakConserveRestAndRepeat) {
  test::ServeProcess server;
  const Options options = options_for(server, GetParam().name, GetParam().seconds);
  const json first = run(options);
  EXPECT_EQ(first["server"]["failed"], 0) << first["server"]["trouble"];
  EXPECT_EQ(first["game"]["failures"], 0) << first["game"]["trouble"];
  EXPECT_GE(first["game"]["swaps"].get<int>(), 1);
  EXPECT_GE(first["bodies"]["fragments"].get<std::size_t>(), GetParam().fragments);
  EXPECT_GT(first["bodies"]["groups"].get<std::size_t>(), 2u);
  EXPECT_LT(first["game"]["worst_momentum_error"].get<double>(), 1e-4);
  EXPECT_GT(first["bodies"]["lowest"].get<double>(), -0.01);
  EXPECT_LT(first["ledger"]["worst_gain"].get<double>(), 0.01);
  EXPECT_LT(first["ledger"]["deepest_mm"].get<double>(), 5);
  // No piece is thrown too fast. A light fragment leaves a heavy ball, or one that fell from the height of
  // the scene, with at most 1 + restitution times its speed; glass has the highest restitution. Then the
  // fragment itself falls.
  const double fall = 2 * 9.81 * 5, most_restitution = 0.25;
  const double thrown =
      (1 + most_restitution) * std::max(first["fastest_ball"].get<double>(), std::sqrt(fall));
  EXPECT_LT(first["fastest_fragment"].get<double>(), std::sqrt(thrown * thrown + fall));
  // In the second run the server has everything in its cache, and answers faster.
  const json second = run(options);
  EXPECT_EQ(first["fingerprint"], second["fingerprint"]);
  EXPECT_EQ(first["fragments"], second["fragments"]);
  EXPECT_EQ(first["swaps"], second["swaps"]);
}

INSTANTIATE_TEST_SUITE_P(All, Scenes,
                         testing::Values(SceneCase{"monkey", 3, 30}, SceneCase{"panes", 2, 60},
                                         SceneCase{"shop", 2, 60}, SceneCase{"wall", 2, 100},
                                         SceneCase{"concrete", 2, 50}, SceneCase{"temple", 2.5, 40},
                                         SceneCase{"building", 2.5, 60}, SceneCase{"crates", 2, 40},
                                         SceneCase{"ice", 2, 60}),
                         [](const auto& scene) { return scene.param.name; });

TEST(EndToEnd, TheMonkeyComesToRest) {
  test::ServeProcess server;
  Options options = options_for(server, "monkey", 10);
  options.throws = false;
  const json summary = run(options);
  EXPECT_GE(summary["bodies"]["fragments"].get<int>(), 30);
  EXPECT_EQ(summary["bodies"]["moving"], 0);
  EXPECT_EQ(summary["bodies"]["whole"], 0);
  EXPECT_GT(summary["bodies"]["lowest"].get<double>(), -0.01);
}

TEST(EndToEnd, EveryMaterialsRequestIsAccepted) {
  test::ServeProcess server;
  for (const std::string& material : scenes::material_names()) {
    Options options = options_for(server, "panes", 1);
    options.material = material;
    const json summary = run(options);
    EXPECT_GE(summary["game"]["requests"].get<int>(), 1) << material;
    EXPECT_EQ(summary["game"]["failures"], 0) << material << ": " << summary["game"]["trouble"];
  }
}

TEST(EndToEnd, ARecordedGameIsPlayedAgainToTheSameBits) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  Options options = options_for(server, "shop", 1.5);
  options.fixed_step = false;  // in real time: answers take effect whenever they arrive
  options.log = folder / "game.jsonl";
  const json played = run(options);
  EXPECT_GE(played["game"]["swaps"].get<int>(), 1);
  Options again = options_for(server, "monkey", 1);
  again.replay = options.log;
  const json replayed = run(again);
  EXPECT_TRUE(replayed["game"]["diverged"].is_null()) << replayed["game"]["diverged"];
  EXPECT_EQ(replayed["fingerprint"], played["fingerprint"]);
  EXPECT_EQ(replayed["swaps"], played["swaps"]);
}

TEST(EndToEnd, ARecordingThatDoesNotFitIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  test::ServeProcess server;
  Options options = options_for(server, "panes", 0.5);
  options.log = "/dev/full";
  const Expected<json> summary = run_headless(options);
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::kFileAccess);
  EXPECT_NE(summary.error().detail.find("/dev/full"), std::string::npos);
}

TEST(EndToEnd, AGameIsHeardWhenThingsBreakAndNotBefore) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  const auto heard = [&](const char* name) {
    Options options = options_for(server, "panes", 1.5);
    options.wav = folder / name;
    run(options);
    std::ifstream in(options.wav, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  const std::string first = heard("first.wav");
  constexpr std::size_t kHeader = 44, kFrames = 72000;  // 1.5 s
  ASSERT_EQ(first.size(), kHeader + 4 * kFrames);
  const auto most = [&](double from, double to) {  // from, to: seconds
    int largest = 0;
    for (auto k = static_cast<std::size_t>(from * 96000); k < static_cast<std::size_t>(to * 96000); ++k) {
      const auto low = static_cast<unsigned char>(first[kHeader + 2 * k]),
                 high = static_cast<unsigned char>(first[kHeader + 2 * k + 1]);
      largest = std::max(largest, std::abs(static_cast<std::int16_t>(low | high << 8)));
    }
    return largest;
  };
  EXPECT_EQ(most(0, 0.3), 0);  // the ball is thrown at 0.3 s
  EXPECT_GT(most(0.3, 1.5), 1000);
  EXPECT_LT(most(0, 1.5), 32767);
  EXPECT_EQ(first, heard("second.wav"));
}

TEST(EndToEnd, AnotherSeedBreaksOtherwise) {
  test::ServeProcess server;
  Options options = options_for(server, "monkey", 1.5);
  const json first = run(options);
  options.seed = 2;
  EXPECT_NE(first["fingerprint"], run(options)["fingerprint"]);
}

TEST(EndToEnd, WithoutAnticipationTheContactAsks) {
  test::ServeProcess server;
  Options options = options_for(server, "panes", 1.2);
  options.anticipate = false;
  const json summary = run(options);
  EXPECT_GE(summary["game"]["swaps"].get<int>(), 1);
  EXPECT_GT(summary["bodies"]["groups"].get<int>(), 1);
}

TEST(EndToEnd, AServerThatIsKilledAndStartedAgainIsUsedAgain) {
  std::optional<test::ServeProcess> server(std::in_place);
  protocol::Settings settings;
  settings.port = server->port;
  settings.patience = protocol::Milliseconds(200);
  settings.longest_pause = protocol::Milliseconds(50);
  protocol::Client client(settings);
  Expected<scenes::Scene> scene = scenes::make_scene("panes");
  ASSERT_TRUE(scene);
  const glm::dvec3 first_pane = scene->objects[0].pose.position, last_pane = scene->objects[4].pose.position;
  game::Game game(std::move(*scene), client, {});
  const auto frame = [&] {
    game.advance(1.0 / 60, true);
    // pause: a game draws here; how many frames an answer takes is not judged
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  while (game.meshes_stored() == 0) frame();
  // In mid-request: the request has left, or its answer is on its way.
  game.throw_ball(first_pane + glm::dvec3(0, 0, 3), {0, 1, -14});
  while (game.figures().requests == 0) frame();
  server->signal(SIGKILL);
  server->wait();
  while (game.figures().swaps + game.figures().failures == 0) frame();
  // No server is running.
  const std::uint64_t failures = game.figures().failures;
  game.throw_ball(last_pane + glm::dvec3(0, 0, 3), {0, 1, -14});
  while (game.figures().failures == failures) frame();
  EXPECT_TRUE(game.world().is_whole(game.things()[4].id));
  EXPECT_FALSE(game.figures().last_trouble.empty());
  // Another server, which knows no mesh.
  const std::uint16_t port = server->port;
  server.reset();
  test::Process again({"serve", "--port", std::to_string(port), "--admin-port", "0", "--drain-delay", "0"});
  const std::uint64_t swaps = game.figures().swaps;
  for (int k = 0; game.figures().swaps == swaps; ++k) {
    if (k % 60 == 0) game.throw_ball(last_pane + glm::dvec3(0, 0, 3), {0, 1, -14});
    frame();
  }
  EXPECT_FALSE(game.world().is_whole(game.things()[4].id) && game.world().is_whole(game.things()[0].id));
  EXPECT_EQ(client.status().state, protocol::ServerState::kReachable);
}

TEST(EndToEnd, FilesFromTheCommandLineFallAndBreak) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  const std::string obj = folder.write("cube.obj",
                                       "v -0.4 -0.4 -0.4\nv 0.4 -0.4 -0.4\nv 0.4 0.4 -0.4\nv -0.4 0.4 -0.4\n"
                                       "v -0.4 -0.4 0.4\nv 0.4 -0.4 0.4\nv 0.4 0.4 0.4\nv -0.4 0.4 0.4\n"
                                       "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  folder.write("crate.glb", scenes::to_glb(scenes::crate(0.8f, 0.1f, 0.03f, 0.07f), "crate", {1, 1, 1, 1}));
  folder.write("notes.stl", "this is no mesh");
  Options options = options_for(server, "", 1.5);
  options.files = {folder / ""};
  const json summary = run(options);
  EXPECT_EQ(summary["scene"], "files");
  EXPECT_EQ(summary["game"]["meshes_stored"], 2);
  EXPECT_GE(summary["game"]["swaps"], 2);  // one for each object, and more for pieces that break again
  EXPECT_LE(summary["game"]["swaps"], 6);
  ASSERT_EQ(summary["warnings"].size(), 2u) << summary["warnings"];  // the notes, and the OBJ's textures
}

TEST(EndToEnd, PicturesShowTheSceneBeforeAndAfter) {
  if (auto context = egl::EglContext::create(); !context) GTEST_SKIP() << context.error().detail;
  test::ServeProcess server;
  test::TemporaryFolder folder;
  Options options = options_for(server, "monkey", 1.19);  // 71.4 frames
  options.width = 320;
  options.height = 180;
  options.screenshots = {0, 1.19};
  options.out = folder / "";
  const json summary = run(options);
  ASSERT_EQ(summary["pictures"].size(), 2u);
  std::vector<render::Picture> pictures;
  for (const json& picture : summary["pictures"]) {
    pictures.push_back(read_picture(picture["file"]));
    EXPECT_EQ(pictures.back().width, 320);
    EXPECT_LE(picture["draw_calls"].get<int>(), 20);
  }
  std::size_t changed = 0;
  for (std::size_t k = 0; k < pictures[0].pixels.size(); ++k) {
    int difference = 0;
    for (std::size_t c = 0; c < 3; ++c)
      difference += std::abs(int(pictures[0].pixels[k][c]) - int(pictures[1].pixels[k][c]));
    changed += difference > 40;
  }
  // The monkey has left its place and lies elsewhere: a few percent of the picture changed, not all of it.
  EXPECT_GT(changed, pictures[0].pixels.size() / 50);
  EXPECT_LT(changed, pictures[0].pixels.size() / 2);
}

/// Mean difference of the colours (0 to 255) over blocks of block_of_a² and block_of_b² pixels, beyond the
/// rounding of a palette.
double difference(const render::Picture& a, int block_of_a, const render::Picture& b, int block_of_b) {
  const render::Picture first = downsample(a, block_of_a), second = downsample(b, block_of_b);
  EXPECT_EQ(first.width, second.width);
  if (first.pixels.size() != second.pixels.size()) return 255;
  constexpr int kPalette = 8;
  double sum = 0;
  for (std::size_t k = 0; k < first.pixels.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      sum += std::max(0, std::abs(int(first.pixels[k][c]) - int(second.pixels[k][c])) - kPalette);
  return sum / (3 * static_cast<double>(first.pixels.size()));
}

class ScenePictures : public testing::TestWithParam<std::string> {};

// Pictures before, during and after the hit, as scripts/client-pictures drew them (the file names contain the
// times). Small pieces may lie elsewhere if the fragments change, but the appearance of a scene must not
// change unnoticed. The README shows one of the later two moments.
TEST_P(ScenePictures, LookAsTheyDidWhenSomebodyLooked) {
  if (auto context = egl::EglContext::create(); !context) GTEST_SKIP() << context.error().detail;
  const std::string scene = GetParam();
  std::vector<double> moments;
  for (const auto& file : std::filesystem::directory_iterator(FRACTURE_SCENE_PICTURES))
    if (const std::string name = file.path().stem(); name.starts_with(scene + "-"))
      moments.push_back(std::stod(name.substr(scene.size() + 1)));
  std::sort(moments.begin(), moments.end());
  ASSERT_EQ(moments.size(), 3u);
  EXPECT_EQ(moments[0], 0);
  test::ServeProcess server;
  test::TemporaryFolder folder;
  Options options = options_for(server, scene, moments.back());
  options.width = 320;
  options.height = 180;
  options.screenshots = moments;
  options.out = folder / "";
  const json summary = run(options);
  std::vector<render::Picture> now, known;
  for (const json& shot : summary["pictures"]) {
    const std::filesystem::path file = shot["file"].get<std::string>();
    now.push_back(read_picture(file));
    known.push_back(read_picture(FRACTURE_SCENE_PICTURES "/" + file.filename().string()));
  }
  ASSERT_EQ(now.size(), 3u);
  // Each picture resembles the one from its own moment, and clearly more than the others of the scene.
  for (std::size_t k = 0; k < 3; ++k) {
    const double own = difference(now[k], 2, known[k], 2);
    EXPECT_LT(own, 3) << moments[k];
    for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3})
      EXPECT_LT(own, 0.6 * difference(now[k], 2, known[other], 2)) << moments[k] << " " << moments[other];
  }
  // The README shows the high tier.
  options.picture = render::TierWish::kHigh;
  const json high = run(options);
  const auto away = [&](std::size_t shot) {
    return difference(read_picture(high["pictures"][shot]["file"].get<std::string>()), 2,
                      read_picture(FRACTURE_PICTURES "/" + scene + ".png"), 4);
  };
  EXPECT_LT(std::min(away(1), away(2)), 3);
  EXPECT_LT(std::min(away(1), away(2)), 0.8 * away(0));  // panes are clear, so little changes
}

INSTANTIATE_TEST_SUITE_P(All, ScenePictures, testing::ValuesIn(scenes::scene_names()),
                         [](const auto& scene) { return scene.param; });

TEST(EndToEnd, TheExampleInPythonBreaksAMesh) {
  test::ServeProcess server;
  test::TemporaryFolder folder;
  const std::string mesh =
      folder.write("box.glb", scenes::to_glb(scenes::box({1, 1, 1}), "box", {1, 1, 1, 1}));
  const std::string command = std::string("python3 ") + FRACTURE_EXAMPLE +
                              " http://127.0.0.1:" + std::to_string(server.port) + " " + mesh + " " +
                              (folder / "out.glb") + " '{\"sites\": 12}' > " + (folder / "list");
  for (int k = 0; k < 2; ++k) ASSERT_EQ(std::system(command.c_str()), 0);  // unknown mesh, then known
  std::ifstream list(folder / "list");
  std::size_t lines = 0;
  double mass = 0;
  for (std::string line; std::getline(list, line); ++lines)
    mass += std::strtod(line.c_str() + line.find(' '), nullptr);
  EXPECT_EQ(lines, 12u);
  EXPECT_NEAR(mass, 1000, 0.1);  // a cubic metre of the default density
  EXPECT_GT(std::filesystem::file_size(folder / "out.glb"), 1000u);
}

}  // namespace
}  // namespace fracture::app
