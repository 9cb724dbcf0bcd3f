// Cameras and the places of fragments, without a display.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "client/render/fragment_views.hpp"
#include "tests/client/models.hpp"

namespace fracture::test {
namespace {

using namespace fracture::render;

glm::vec3 place(const Model& model, const ObjectState& state, std::size_t object) {
  return glm::vec3(state.transform * glm::vec4(model.objects[object].bounds.center, 1));
}

TEST(FitCamera, SeesTheWholeSphereAndNotMuchMore) {
  std::mt19937 random(7);
  std::normal_distribution<float> normal;
  for (const bool orthographic : {false, true})
    for (const float aspect : {0.5f, 1.f, 2.f}) {
      CameraPlacement placement;
      placement.orthographic = orthographic;
      placement.margin = 1;
      const Sphere sphere{{3, -2, 5}, 4};
      const Camera camera = fit_camera(sphere, placement, aspect);
      float widest = 0;
      for (int k = 0; k < 20000; ++k) {
        const glm::vec3 d = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
        const glm::vec4 clip = camera.view_projection() * glm::vec4(sphere.center + sphere.radius * d, 1);
        const glm::vec3 p = glm::vec3(clip) / clip.w;
        for (int axis = 0; axis < 3; ++axis) ASSERT_LE(std::abs(p[axis]), 1.0001f);
        widest = std::max({widest, std::abs(p.x), std::abs(p.y)});
      }
      EXPECT_GT(widest, 0.99f) << "aspect " << aspect;
    }
}

TEST(FitCamera, HasItsTargetInTheMiddle) {
  const Sphere sphere{{3, -2, 5}, 4};
  for (const bool orthographic : {false, true}) {
    CameraPlacement placement;
    placement.orthographic = orthographic;
    const Camera whole = fit_camera(sphere, placement, 1.5f);
    placement.target = glm::vec3(4, 0, 4);
    const Camera camera = fit_camera(sphere, placement, 1.5f);
    const glm::vec4 clip = camera.view_projection() * glm::vec4(*placement.target, 1);
    EXPECT_NEAR(clip.x / clip.w, 0, 1e-5);
    EXPECT_NEAR(clip.y / clip.w, 0, 1e-5);
    EXPECT_NEAR(glm::distance(camera.eye, *placement.target), glm::distance(whole.eye, sphere.center), 1e-4);
  }
}

TEST(FrustumPlanes, TellInsideFromOutside) {
  const Camera camera = fit_camera({{0, 0, 0}, 1}, {}, 1);
  const auto planes = frustum_planes(camera.view_projection());
  const glm::vec3 forward = glm::normalize(-camera.eye),
                  right = glm::normalize(glm::cross(forward, glm::vec3(0, 1, 0)));
  EXPECT_TRUE(touches(planes, {{0, 0, 0}, 0.1f}));
  EXPECT_FALSE(touches(planes, {camera.eye - 2.f * forward, 0.5f}));  // behind
  EXPECT_FALSE(touches(planes, {10.f * right, 0.5f}));
  EXPECT_TRUE(touches(planes, {10.f * right, 10.f}));
}

TEST(ExplodedView, MovesEveryFragmentAwayFromTheCentreByTheFactor) {
  const Model model = cube_of_fragments(3);
  ViewOptions options;
  options.view = View::kExploded;
  options.explode = 0.5f;
  const auto states = view_states(model, options, {});
  for (std::size_t k = 0; k < states.size(); ++k)
    EXPECT_LT(glm::distance(place(model, states[k], k), 1.5f * model.objects[k].fragment->centroid), 1e-6f);
  // The corner of a corner fragment: its centre moved from (1/3, 1/3, 1/3), and half its side stays 1/6.
  EXPECT_NEAR(bounding_sphere(model, states).radius, std::sqrt(3.0) * (1.5 / 3 + 1.0 / 6), 1e-6);
}

TEST(ExplodedView, ByGroupKeepsAGroupTogether) {
  const Model model = cube_of_fragments(2);
  ViewOptions options;
  options.view = View::kExploded;
  options.by_group = true;
  options.level = 0;  // slabs across x
  options.explode = 1;
  const auto states = view_states(model, options, {});
  for (std::size_t k = 0; k < states.size(); ++k) {
    const glm::vec3 before = model.objects[k].fragment->centroid, shift = place(model, states[k], k) - before;
    EXPECT_LT(glm::distance(shift, glm::vec3(before.x, 0, 0)), 1e-6f);
  }
}

TEST(ImpactView, ThrowsWhatIsNearAndLeavesTheRest) {
  const Model model = cube_of_fragments(4);
  ViewOptions options;
  options.view = View::kImpact;
  options.impact_point = glm::vec3(0, 0, 0.5f);
  options.impact_radius = 0.5f;
  const auto states = view_states(model, options, {});
  std::size_t thrown = 0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const bool near = glm::distance(model.objects[k].fragment->centroid, *options.impact_point) < 0.5f;
    const bool moved = states[k].transform != model.objects[k].transform;
    EXPECT_EQ(moved, near) << "fragment " << k;
    thrown += moved;
    EXPECT_NEAR(glm::determinant(states[k].transform), 1, 1e-5) << "a rigid move";
    EXPECT_GT(place(model, states[k], k).y, -0.5f) << "not below the ground";
  }
  EXPECT_GT(thrown, 4u);
  EXPECT_LT(thrown, states.size());
  const auto again = view_states(model, options, {});
  for (std::size_t k = 0; k < states.size(); ++k) EXPECT_EQ(states[k].transform, again[k].transform);
}

TEST(FirstHit, IsTheNearestOfTheFacesOnTheRay) {
  const Model model = cube_of_fragments(2);
  const auto hit = first_hit(model, {0.1f, 0.2f, 5}, {0, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_LT(glm::distance(*hit, glm::vec3(0.1f, 0.2f, 0.5f)), 1e-5f);
  EXPECT_FALSE(first_hit(model, {0.1f, 0.2f, 5}, {0, 0, 1}));
  EXPECT_FALSE(first_hit(model, {2, 0, 5}, {0, 0, -1}));
}

TEST(Colors, OfFragmentsAreDistinctAndThoseOfALevelFollowItsGroups) {
  const Model model = cube_of_fragments(3);
  ViewOptions options;
  options.colors = Colors::kFragment;
  std::set<std::array<float, 3>> colors;
  for (const ObjectState& s : view_states(model, options, {})) {
    EXPECT_EQ(s.tint.a, 1);
    colors.insert({s.tint.r, s.tint.g, s.tint.b});
  }
  EXPECT_EQ(colors.size(), 27u);
  options.colors = Colors::kLevel;
  options.level = 0;
  const auto states = view_states(model, options, {});
  for (std::size_t k = 0; k < states.size(); ++k)
    for (std::size_t j = 0; j < k; ++j)
      EXPECT_EQ(states[k].tint == states[j].tint,
                model.objects[k].fragment->ancestors[0] == model.objects[j].fragment->ancestors[0]);
}

}  // namespace
}  // namespace fracture::test
