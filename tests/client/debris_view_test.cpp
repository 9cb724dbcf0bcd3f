// Dust, crumbs and marks as pixels.
#include "client/effects/debris_view.hpp"

#include <cmath>

#include "tests/client/cubes.hpp"
#include "tests/client/renderer_fixture.hpp"

namespace fracture::test {
namespace {

using effects::Debris;
using effects::DebrisView;
using effects::Mark;
using effects::PlacedMark;

class DebrisViewTest : public RendererTest {
 protected:
  void SetUp() override {
    RendererTest::SetUp();
    if (IsSkipped()) return;
    auto made = DebrisView::create();
    ASSERT_TRUE(made) << made.error().detail;
    view_.emplace(std::move(*made));
  }

  /// Draws a cube of side 1 around the origin from the front, with debris over it. The camera looks along −z.
  render::Picture shown(const Debris& debris, std::span<const PlacedMark> marks = {}) {
    return shown(debris, marks, camera_, false);
  }
  render::Picture shown(const Debris& debris, std::span<const PlacedMark> marks, const render::Camera& camera,
                        bool sun_shadow) {
    const render::Model model = red_cube();
    auto gpu = render::GpuModel::upload(std::make_shared<const render::Model>(model));
    auto target = render::FrameTarget::create(kSide, kSide);
    if (!gpu || !target) throw std::runtime_error("no picture");
    render::RenderSettings settings = bare();
    settings.background = true;
    settings.background_top = settings.background_bottom = glm::vec3(0.02f);
    settings.lighting.sun_shadow = sun_shadow;
    settings.lit = render::Sphere{{0, 0, 0}, 3};
    const auto states = initial_states(model);
    renderer->draw(*gpu, states, camera, settings, target->framebuffer(), kSide, kSide);
    calls_ = view_->draw(debris, marks, camera, target->framebuffer(), kSide, kSide);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    return target->read();
  }

  /// The debris of a crack at this point, `seconds` later.
  static Debris dust_at(const glm::dvec3& point, const std::string& material, double seconds = 0.15) {
    world::WorldSettings settings;
    settings.gravity = glm::dvec3(0);
    world::World world(settings);
    world::Witnessed seen;
    for (int k = 0; k < 30; ++k) seen.cracks.push_back({.point = point, .normal = {0, 0, 1}, .area = 0.02});
    Debris debris;
    const auto named = [&](world::ObjectId) { return material; };
    debris.follow(world, seen, named);
    run(world, seconds);
    debris.follow(world, {}, named);
    return debris;
  }

  static double difference(const render::Picture& a, const render::Picture& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.pixels.size(); ++k)
      sum += std::abs(luminance(a.pixels[k]) - luminance(b.pixels[k]));
    return sum / static_cast<double>(a.pixels.size());
  }

  static constexpr int kSide = 200;
  const render::Camera camera_ = [] {
    render::Camera camera;
    camera.eye = {0, 0, 4};
    camera.view = glm::lookAt(camera.eye, glm::vec3(0), glm::vec3(0, 1, 0));
    camera.projection = glm::perspective(glm::radians(50.f), 1.f, 0.05f, 300.f);
    return camera;
  }();
  std::optional<DebrisView> view_;
  std::size_t calls_ = 0;
};

TEST_F(DebrisViewTest, WithoutDebrisThePictureIsAsItWasAndCostsNothing) {
  const render::Picture clean = shown(Debris()), again = shown(Debris());
  EXPECT_EQ(calls_, 0u);
  EXPECT_EQ(clean.pixels, again.pixels);
}

TEST_F(DebrisViewTest, DustIsSeenInFrontAndNotThroughThings) {
  const render::Picture clean = shown(Debris()), in_front = shown(dust_at({0, 0.6, 1.2}, "concrete"));
  EXPECT_EQ(calls_, 2u);
  EXPECT_GT(difference(clean, in_front), 0.003);
  // The dust is behind the cube, which hides all of it.
  const render::Picture behind = shown(dust_at({0, 0, -0.9}, "ceramic", 0.01));
  EXPECT_LT(difference(clean, behind), 1e-4);
}

TEST_F(DebrisViewTest, EqualDebrisGivesEqualPixels) {
  const Debris debris = dust_at({0, 0, 1}, "ice");
  EXPECT_EQ(shown(debris).pixels, shown(debris).pixels);
}

TEST_F(DebrisViewTest, AMarkIsOnTheSurfaceItWasMadeOnAndNowhereElse) {
  Mark mark;
  mark.radius = 0.3f;
  mark.color = glm::vec3(0.9f);
  mark.opacity = 1;
  const PlacedMark front{&mark, {0, 0, 0.5f}, {0, 0, 1}}, air{&mark, {1.2f, 0, 0.5f}, {0, 0, 1}};
  const render::Picture clean = shown(Debris()), marked = shown(Debris(), std::span(&front, 1));
  EXPECT_EQ(calls_, 1u);
  // The cube is red; the mark is white.
  EXPECT_GT(pixel_at(marked, camera_, {0, 0, 0.5f})[1], pixel_at(clean, camera_, {0, 0, 0.5f})[1] + 40);
  EXPECT_EQ(pixel_at(marked, camera_, {0.4f, 0.4f, 0.5f}), pixel_at(clean, camera_, {0.4f, 0.4f, 0.5f}));
  EXPECT_EQ(shown(Debris(), std::span(&air, 1)).pixels, clean.pixels);
}

TEST_F(DebrisViewTest, CrumbsInTheShadowAreDarker) {
  // From the first point, the way to the sun (0.43, 0.77, 0.48) goes through the cube; from the second it is
  // free.
  const glm::dvec3 shaded(-0.72, -0.3, 0), sunny(0.9, 0.6, 0.4);
  const auto brightest = [&](const glm::dvec3& place) {
    render::Camera close = camera_;  // a pixel is two millimetres there
    close.view = glm::lookAt(close.eye, glm::vec3(place), glm::vec3(0, 1, 0));
    close.projection = glm::perspective(glm::radians(6.f), 1.f, 0.05f, 300.f);
    const Debris debris = dust_at(place, "metal", 0.01);
    if (debris.crumbs().empty()) throw std::runtime_error("no crumbs");
    const render::Picture clean = shown(Debris(), {}, close, true), with = shown(debris, {}, close, true);
    double most = 0;
    for (std::size_t k = 0; k < with.pixels.size(); ++k)
      if (with.pixels[k] != clean.pixels[k]) most = std::max(most, luminance(with.pixels[k]));
    return most;
  };
  const double light = brightest(sunny), shadow = brightest(shaded);
  ASSERT_GT(shadow, 0) << "it is seen";
  EXPECT_GT(light, 1.5 * shadow);
}

}  // namespace
}  // namespace fracture::test
