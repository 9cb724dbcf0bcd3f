// Several models in one picture, batches, wireframes, and copying to a window.
#include <gtest/gtest.h>

#include <array>

#include "tests/client/models.hpp"
#include "tests/client/renderer_fixture.hpp"

namespace fracture::test {
namespace {

using namespace fracture::render;

TEST_F(RendererTest, SeveralScenesStandInOnePictureAndHideOneAnother) {
  Model red = red_cube(), blue;
  blue.materials.push_back(paint({0.02f, 0.02f, 0.8f}));
  add_box(blue, {0, 0, 0}, {1, 1, 1});
  auto first = GpuModel::upload(std::make_shared<const Model>(red)),
       second = GpuModel::upload(std::make_shared<const Model>(blue));
  ASSERT_TRUE(first && second);
  auto of_red = initial_states(red), of_blue = initial_states(blue);
  // The blue cube is behind the red one and rises a quarter above it.
  of_blue[0].transform[3] = {0, 0.25f, -2, 1};
  auto target = FrameTarget::create(300, 300);
  ASSERT_TRUE(target);
  const Camera camera = straight(0, 0);
  const std::array<DrawItem, 2> items = {DrawItem{.model = &*first, .states = of_red},
                                         DrawItem{.model = &*second, .states = of_blue}};
  stats = renderer->draw(items, camera, bare(), target->framebuffer(), 300, 300);
  const Picture picture = target->read();
  EXPECT_EQ(stats.draw_calls, 2u);
  EXPECT_EQ(stats.surfaces, 12u);
  EXPECT_NEAR(coverage(picture), 1.25 / 3, 0.01);  // a square is a third of the picture
  const Color front = pixel_at(picture, camera, {0, 0.2f, 0}),
              above = pixel_at(picture, camera, {0, 0.6f, 0});
  EXPECT_GT(linear(front[0]), 3 * linear(front[2]));
  EXPECT_GT(linear(above[2]), 3 * linear(above[0]));
}

TEST_F(RendererTest, EachOfSeveralScenesHasALookOfItsOwn) {
  const Model cube = red_cube();
  auto gpu = GpuModel::upload(std::make_shared<const Model>(cube));
  ASSERT_TRUE(gpu);
  const auto states = initial_states(cube);
  auto target = FrameTarget::create(100, 100);
  ASSERT_TRUE(target);
  const Camera camera = straight(30, 20);
  const auto with = [&](SolidLook look) {
    const DrawItem item{.model = &*gpu, .states = states, .look = look};
    renderer->draw(std::span(&item, 1), camera, bare(), target->framebuffer(), 100, 100);
    return target->read();
  };
  RenderSettings of_all = bare();
  of_all.look = SolidLook::kBrick;
  EXPECT_EQ(with(SolidLook::kBrick).pixels, draw(cube, camera, of_all, 100, 100).pixels);
  EXPECT_NE(with(SolidLook::kBrick).pixels, with(SolidLook::kWood).pixels);
}

TEST_F(RendererTest, ABatchShowsWhatItsScenesShowInOneCall) {
  Model left = red_cube(), right = red_cube();
  auto of_left = initial_states(left), of_right = initial_states(right);
  of_left[0].transform[3] = {-0.4f, 0, 0, 1};
  of_right[0].transform[3] = {0.3f, 0.2f, 0.1f, 1};
  auto first = GpuModel::upload(std::make_shared<const Model>(left)),
       second = GpuModel::upload(std::make_shared<const Model>(right)), batch = GpuModel::batch();
  ASSERT_TRUE(first && second && batch);
  auto target = FrameTarget::create(200, 200);
  ASSERT_TRUE(target);
  const Camera camera = straight(30, 20);
  const std::array<DrawItem, 2> apart = {DrawItem{.model = &*first, .states = of_left},
                                         DrawItem{.model = &*second, .states = of_right}};
  renderer->draw(apart, camera, bare(), target->framebuffer(), 200, 200);
  const Picture expected = target->read();

  EXPECT_EQ(*batch->append(left, std::nullopt), 0u);
  EXPECT_EQ(*batch->append(right, std::nullopt), 1u);
  EXPECT_EQ(batch->model().materials.size(), 1u);  // equal materials are stored once
  const std::array<ObjectState, 2> states = {of_left[0], of_right[0]};
  const DrawItem together{.model = &*batch, .states = states};
  stats = renderer->draw(std::span(&together, 1), camera, bare(), target->framebuffer(), 200, 200);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  EXPECT_EQ(target->read().pixels, expected.pixels);
  EXPECT_EQ(stats.draw_calls, 1u);
  EXPECT_EQ(stats.surfaces, 12u);
}

TEST_F(RendererTest, ABatchThatGrowsKeepsWhatIsInIt) {
  auto batch = GpuModel::batch();
  ASSERT_TRUE(batch);
  const Model cube = red_cube();
  std::vector<ObjectState> states;
  for (std::uint32_t k = 0; k < 40; ++k) {
    ASSERT_EQ(*batch->append(cube, std::nullopt), k);
    states.push_back(initial_states(cube)[0]);
    states.back().visible = k == 0;  // the first one survived every growth of the batch
  }
  auto target = FrameTarget::create(300, 300);
  ASSERT_TRUE(target);
  const DrawItem item{.model = &*batch, .states = states};
  renderer->draw(std::span(&item, 1), straight(30, 20), bare(), target->framebuffer(), 300, 300);
  EXPECT_EQ(target->read().pixels, draw(cube, straight(30, 20), bare()).pixels);
}

TEST_F(RendererTest, AWallOfBricksHasJointsWhereItsCoursesSay) {
  Model wall;
  wall.materials.push_back(paint({0.5f, 0.1f, 0.1f}));
  add_box(wall, {0, 0, 0}, {1, 1, 0.2f});
  wall.objects[0].solid = SolidPlacement{.frame = {{0, 0, 0}, 1},
                                         .brick = {0.5f, 0.25f},
                                         .brick_low = {-0.5f, -0.5f},
                                         .brick_high = {0.5f, 0.5f}};
  RenderSettings settings = bare();
  settings.look = SolidLook::kBrick;
  const Camera camera = straight(0, 0);
  const Picture picture = draw(wall, camera, settings, 600, 600);
  const auto red = [&](float x, float y) {
    const Color c = pixel_at(picture, camera, {x, y, 0.1f});
    return linear(c[0]) / (linear(c[2]) + 1e-3);
  };
  // The lowest course has a joint in the middle, the next one a quarter from the ends. Between the courses
  // one joint runs along all of them.
  EXPECT_LT(red(0, -0.375f), 2);
  EXPECT_GT(red(0.25f, -0.375f), 3);
  EXPECT_LT(red(0.25f, -0.125f), 2);
  EXPECT_GT(red(0, -0.125f), 3);
  EXPECT_LT(red(0.1f, -0.25f), 2);
}

TEST_F(RendererTest, WireframeShowsTheEdgesAndLeavesTheFacesOpen) {
  RenderSettings settings = bare();
  const double solid = coverage(draw(red_cube(), straight(30, 20), settings));
  settings.wireframe = true;
  const double edges = coverage(draw(red_cube(), straight(30, 20), settings));
  EXPECT_GT(edges, 0.005);
  EXPECT_LT(edges, 0.2 * solid);
}

TEST_F(RendererTest, AFrameIsCopiedToAWindowByteForByte) {
  const Model cube = red_cube();
  auto gpu = GpuModel::upload(std::make_shared<const Model>(cube));
  auto target = FrameTarget::create(40, 30);
  ASSERT_TRUE(gpu && target);
  renderer->draw(*gpu, initial_states(cube), straight(30, 20), {}, target->framebuffer(), 40, 30);
  // A window's framebuffer: one sample, and sRGB bytes that the driver does not know to be sRGB.
  GLuint window = 0, color = 0;
  glGenFramebuffers(1, &window);
  glGenRenderbuffers(1, &color);
  glBindRenderbuffer(GL_RENDERBUFFER, color);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, 40, 30);
  glBindFramebuffer(GL_FRAMEBUFFER, window);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
  target->copy_to(window);
  std::vector<Color> bytes(40 * 30);
  glReadPixels(0, 0, 40, 30, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDeleteRenderbuffers(1, &color);
  glDeleteFramebuffers(1, &window);
  const Picture picture = target->read();
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      ASSERT_EQ(bytes[static_cast<std::size_t>((29 - y) * 40 + x)], picture.at(x, y)) << x << ", " << y;
}

}  // namespace
}  // namespace fracture::test
