#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

Scene ice() {
  Scene scene;
  scene.title = "Blocks of ice";
  const glm::vec4 clear(0.75f, 0.88f, 0.95f, 1);
  const auto block = share(make_asset(box({0.9f, 0.5f, 0.6f}, 0.03f), "block", clear));
  Turned shape;
  shape.segments = 24;
  shape.profile = {{0.34f, 0.0f}, {0.36f, 0.05f}, {0.28f, 0.5f},
                   {0.18f, 1.0f}, {0.10f, 1.4f},  {0.05f, 1.55f}};
  const auto cone = share(make_asset(turned(shape), "icicle", clear));
  const auto put = [&](const auto& mesh, const char* name, double x, double y, double z, double degrees) {
    SceneObject object;
    object.name = name;
    object.mesh = mesh;
    object.pose = at(x, y, z, degrees);
    scene.objects.push_back(object);
  };
  constexpr double kGap = 0.001;
  // A wall of three courses with staggered joints, and two cones in front of it.
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < (row % 2 == 0 ? 4 : 3); ++k)
      put(block, "block", 0.93 * (k - (row % 2 == 0 ? 1.5 : 1.0)), 0.25 + kGap + row * (0.5 + kGap), 0, 0);
  put(cone, "icicle", -1.1, kGap, 1.1, 0);
  put(cone, "icicle", 1.3, kGap, 0.9, 30);
  set_material(scene, "ice");
  for (SceneObject& object : scene.objects) object.breakage.sites = 40;
  scene.ball_radius = 0.18;
  scene.ball_density = 7800;
  scene.ball_speed = 13;
  scene.eye = {2.4f, 1.6f, 4.2f};
  scene.target = {0.1f, 0.75f, 0};
  scene.bounds = {{0, 0.8f, 0}, 4};
  scene.throws = {{0.3, {0.6, 1.3, 6}, {-0.6, 1.2, -13}}, {1.3, {-2.2, 1.3, 6}, {1.3, 1.0, -12}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
