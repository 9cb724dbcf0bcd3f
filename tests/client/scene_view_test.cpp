// The game as the renderer receives it: what is uploaded and when, and that nothing is left behind.
#include "client/view/scene_view.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdlib>

#include "client/egl/egl_context.hpp"
#include "client/render/frame_target.hpp"
#include "client/view/held_cuts.hpp"
#include "tests/client/falling_box.hpp"
#include "tests/support/eventually.hpp"

namespace fracture::view {
namespace {

using test::FakeReply;
using test::FakeRequest;
using test::FakeServer;
using test::falling_box;

constexpr int kSize = 32;  // pixels: the picture itself does not matter here

class SceneViewTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = egl::EglContext::create();
    if (!context) GTEST_SKIP() << context.error().detail;
    context_.emplace(std::move(*context));
    auto target = render::FrameTarget::create(kSize, kSize);
    ASSERT_TRUE(target) << target.error().detail;
    target_.emplace(std::move(*target));
    auto view = SceneView::create();
    ASSERT_TRUE(view) << view.error().detail;
    view_.emplace(std::move(*view));
  }
  ViewFigures draw(const game::Game& game, const game::Moment* past = nullptr) {
    ViewSettings settings;
    settings.sky_shadows = 1;
    const std::vector<game::Game::Coming> coming = game.coming();
    if (past == nullptr) settings.coming = &coming;
    const auto figures =
        view_->draw(game.scene(), past != nullptr ? *past : game::moment_of(game),
                    look_at({0, 2, 6}, {0, 1, 0}, 1), settings, target_->framebuffer(), kSize, kSize);
    if (!figures) throw std::runtime_error(figures.error().detail);
    return *figures;
  }

  /// Bytes in all threads, without the requests that the fake server keeps. It waits until no request is open
  /// and nothing is being drawn.
  std::ptrdiff_t in_use() {
    glFinish();
    test::require_eventually(test::kPatience, "the requests to end",
                             [&] { return client_.status().open == 0; });
    auto bytes = static_cast<std::ptrdiff_t>(::mallinfo2().uordblks);
    for (const FakeRequest& request : server_.requests())
      bytes -= static_cast<std::ptrdiff_t>(request.method.capacity() + request.target.capacity() +
                                           request.head.capacity() + request.body.capacity());
    return bytes;
  }

  const std::string bytes_ = test::two_cubes_glb().bytes();
  FakeServer server_{[this](const FakeRequest& request) {
    return request.method == "PUT" ? FakeReply::answer(201, "{}") : test::glb(bytes_);
  }};
  protocol::Client client_{test::settings_for(server_)};
  std::optional<egl::EglContext> context_;
  std::optional<render::FrameTarget> target_;
  std::optional<SceneView> view_;
};

TEST_F(SceneViewTest, TheHighTierIsDrawnAndDebugViewsAreLow) {
  game::Game game(falling_box(), client_, {});
  const auto drawn = [&](render::Tier tier, DebugView debug) {
    ViewSettings settings;
    settings.tier = tier;
    settings.debug = debug;
    const auto figures =
        view_->draw(game.scene(), game::moment_of(game, tier == render::Tier::kHigh),
                    look_at({0, 2, 6}, {0, 1, 0}, 1), settings, target_->framebuffer(), kSize, kSize);
    EXPECT_TRUE(figures);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return figures ? figures->tier : render::Tier::kLow;
  };
  EXPECT_EQ(drawn(render::Tier::kHigh, DebugView::kNone), render::Tier::kHigh);
  const auto high = target_->read().pixels;
  EXPECT_EQ(drawn(render::Tier::kHigh, DebugView::kBonds), render::Tier::kLow);
  EXPECT_EQ(drawn(render::Tier::kLow, DebugView::kNone), render::Tier::kLow);
  EXPECT_NE(target_->read().pixels, high);
}

TEST(HeldCuts, OnlyOfGroupsWhoseBondsAllHold) {
  world::FragmentSet set;
  set.fragments.resize(5);
  const auto bond = [&](std::uint32_t a, std::uint32_t b, bool gone = false) {
    world::Bond made;
    made.a = a;
    made.b = b;
    made.gone = gone;
    set.bonds.push_back(made);
  };
  // A row of four fragments, and one by itself.
  bond(0, 1);
  bond(1, 2);
  bond(2, 3);
  std::vector<world::FragmentState> states(5);
  for (world::FragmentState& s : states) s.present = true;
  using Held = std::vector<bool>;
  EXPECT_EQ(in_whole_groups(set, states, {0, 0.5f, 0}), (Held{true, true, true, true, false}));
  EXPECT_EQ(in_whole_groups(set, states, {0, -1, 0}), (Held{false, false, false, false, false}));
  states[3].group = 7;
  EXPECT_EQ(in_whole_groups(set, states, {0, 0, 0}), (Held{false, false, false, false, false}))
      << "both have lost one";
  states[2].group = 7;  // two connected fragments have separated from the others, so bonds of both are broken
  EXPECT_EQ(in_whole_groups(set, states, {0, 0, 0}), (Held{false, false, false, false, false}));
  set.bonds[1].gone = true;  // and were replaced by others
  EXPECT_EQ(in_whole_groups(set, states, {0, 0, 0}), (Held{true, true, true, true, false}));
  EXPECT_EQ(in_whole_groups(set, states, {-1, 0, 0}), (Held{false, false, true, true, false}));
  set.bonds[1].gone = false;
  states[3].group = states[2].group = states[1].group;
  states[0].present = false;
  EXPECT_FALSE(in_whole_groups(set, states, {0, 0, 0})[1]);
  // A fragment that a later hit replaced leaves no gap.
  set.bonds[0].gone = true;
  EXPECT_EQ(in_whole_groups(set, states, {-1, 0, 0}), (Held{false, true, true, true, false}));
}

TEST_F(SceneViewTest, FragmentsAreUploadedInAFrameBeforeTheyAreSeen) {
  game::GameSettings settings;
  settings.anticipate = false;  // otherwise they wait for the hit
  game::Game game(falling_box(), client_, settings);
  draw(game);
  ASSERT_TRUE(test::eventually(test::kPatience, "fragments to upload", [&] {
    if (!game.coming().empty()) return true;
    game.advance(test::kFrame, true);
    EXPECT_EQ(game.figures().swaps, 0u) << "bodies were swapped before anybody could upload them";
    return false;
  }));
  EXPECT_EQ(draw(game).uploads, 1u);
  EXPECT_EQ(draw(game).uploads, 0u) << "once is enough";
  const std::uint64_t steps = game.world().steps();
  game.advance(test::kFrame, true);
  EXPECT_EQ(game.figures().swaps, 1u);
  EXPECT_TRUE(game.coming().empty());
  EXPECT_EQ(game.world().steps(), steps + 1) << "the first step of new pieces has its frame to itself";
  EXPECT_EQ(draw(game).uploads, 0u);
  game.advance(test::kFrame, true);
  EXPECT_EQ(game.world().steps(), steps + 3);
}

TEST_F(SceneViewTest, ThePastIsDrawnAsItWas) {
  game::GameSettings settings;
  settings.fixed_latency = 2;
  game::Game game(falling_box(), client_, settings);
  const auto step_until = [&](std::uint64_t steps) {
    while (game.world().steps() < steps) {
      test::require_eventually(test::kPatience, "the answers of the step", [&] { return game.ready(); });
      game.step();
    }
  };
  const auto pixels = [&](const game::Moment* past) {
    draw(game, past);
    return target_->read().pixels;
  };
  std::vector<game::Moment> moments;
  std::vector<std::vector<render::Color>> seen;
  // Falling, broken, with a ball, without it.
  for (const std::uint64_t steps : {10u, 60u, 90u, 240u}) {
    step_until(steps);
    if (steps == 60) game.throw_ball({0.5, 1, 3}, {0, 3, -2});
    moments.push_back(game::moment_of(game));
    seen.push_back(pixels(nullptr));
  }
  ASSERT_FALSE(moments[0].parts[0].broken);
  ASSERT_TRUE(moments[1].parts[0].broken);
  EXPECT_NE(seen[0], seen[1]);
  EXPECT_NE(seen[1], seen[2]);
  for (const std::size_t k : {2u, 0u, 1u, 3u}) EXPECT_EQ(pixels(&moments[k]), seen[k]) << k;
  EXPECT_EQ(pixels(nullptr), seen[3]);
}

TEST_F(SceneViewTest, OfAFurtherHitOnlyWhatItChangedIsUploaded) {
  const auto sound = [](test::GlbParts parts) {
    for (auto& strength : parts.json["nodes"][0]["extras"]["fracture"]["bonds"]["strength"]) strength = 1e12;
    return parts.bytes();
  };
  const std::string whole = sound(test::two_cubes_glb()), change = sound(test::halved_cube_glb());
  FakeServer server([&](const FakeRequest& request) {
    if (request.method == "PUT") return FakeReply::answer(201, "{}");
    const bool again = request.body.find("\"of\"") != std::string::npos;
    const std::string& bytes = again ? change : whole;
    return FakeReply::answer(200, bytes,
                             test::digest_field(bytes) + "Content-Location: /fractures/sha256:aa\r\n");
  });
  protocol::Client client(test::settings_for(server));
  scenes::Scene scene = falling_box();
  scene.objects[0].held = true;
  game::GameSettings settings;
  settings.fixed_latency = 6;
  game::Game game(std::move(scene), client, settings);
  draw(game);
  std::size_t uploads = 0;
  const auto play = [&](const auto& done) {
    for (int k = 0; k < 200 && !done(); ++k) {
      test::require_eventually(test::kPatience, "the answer of the step", [&] { return game.ready(); });
      game.step();
      uploads += draw(game).uploads;
    }
  };
  game.throw_ball({0, 1.6, 4}, {0, 0.5, -20});
  play([&] { return !game.world().is_whole(0); });
  EXPECT_EQ(uploads, 1u);
  play([&] { return game.world().steps() > 60; });
  const auto pixels = [&](const game::Moment* past) {
    draw(game, past);
    return target_->read().pixels;
  };
  const game::Moment before = game::moment_of(game);
  const auto seen_before = pixels(nullptr);
  game.throw_ball({1, 1.6, 6}, {0, 0.5, -20});
  play([&] { return game.figures().hits > 0; });
  EXPECT_EQ(game.figures().hits, 1u);
  EXPECT_EQ(uploads, 2u);
  // The past is drawn as it was, with fragments that no longer exist.
  const auto seen_now = pixels(nullptr);
  EXPECT_NE(seen_now, seen_before);
  EXPECT_EQ(pixels(&before), seen_before);
  EXPECT_EQ(pixels(nullptr), seen_now);
}

/// Number of existing buffers, textures and vertex arrays. Names are not reused, so a new name is above all
/// of them.
std::size_t gl_objects() {
  GLuint buffer = 0, texture = 0, array = 0;
  glGenBuffers(1, &buffer);
  glGenTextures(1, &texture);
  glGenVertexArrays(1, &array);
  std::size_t count = 0;
  for (GLuint name = 1; name < buffer; ++name) count += glIsBuffer(name);
  for (GLuint name = 1; name < texture; ++name) count += glIsTexture(name);
  for (GLuint name = 1; name < array; ++name) count += glIsVertexArray(name);
  glDeleteBuffers(1, &buffer);
  glDeleteTextures(1, &texture);
  glDeleteVertexArrays(1, &array);
  return count;
}

TEST_F(SceneViewTest, BreaksAndResetsLeaveNothingBehind) {
  constexpr int kWarm = 20;  // cycles until caches are full
  constexpr int kSteps = 2'000;
  constexpr std::ptrdiff_t kScene =
      2'000'000;  // the minimum number of bytes that a cycle uses in this process
  const int cycles = std::getenv("FRACTURE_TEST_FULL") != nullptr ? 200 : 60;
  game::GameSettings settings;
  settings.fixed_latency = 2;
  std::ptrdiff_t early = 0;
  std::size_t early_objects = 0;
  for (int k = 0; k < cycles; ++k) {
    if (k == kWarm) {
      early = in_use();
      early_objects = gl_objects();
    }
    game::Game game(falling_box(), client_, settings);
    draw(game);
    for (int step = 0; game.figures().swaps == 0; ++step) {
      ASSERT_LT(step, kSteps) << "cycle " << k << ": the box has not been broken";
      test::require_eventually(test::kPatience, "the answer of the step", [&] { return game.ready(); });
      game.step();
    }
    EXPECT_GE(draw(game).uploads, 1u) << "cycle " << k;
    view_->reset();
  }
  EXPECT_EQ(gl_objects(), early_objects);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  // A leak of one scene per cycle would be four times this limit. The driver's own caches vary.
  EXPECT_LT(in_use() - early, (cycles - kWarm) * kScene / 4);
}

}  // namespace
}  // namespace fracture::view
