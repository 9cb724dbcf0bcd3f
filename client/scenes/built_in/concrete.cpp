#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

Scene concrete() {
  Scene scene;
  scene.title = "A concrete wall";
  const double length = 3.6, height = 2.4, depth = 0.28;
  SceneObject object;
  object.name = "wall";
  object.mesh =
      share(make_asset(box(glm::vec3(length, height, depth), 0.02f), "wall", {0.42f, 0.41f, 0.39f, 1}));
  object.pose = at(0, height / 2, 0);
  object.held = true;
  object.breakage.parameters["anchor_plane"] = ground_plane(-height / 2 + 0.03);
  scene.objects.push_back(object);
  set_material(scene, "concrete");
  // The concrete is old and weak, so the ball makes a hole.
  scene.objects.front().breakage.parameters["bond_strength"] = 6e5;
  scene.ball_radius = 0.26;
  scene.ball_density = 7800;
  scene.ball_speed = 24;
  scene.eye = {2.7f, 1.7f, 4.0f};
  scene.target = {0.1f, 1.05f, -0.3f};
  scene.bounds = {{0, 1, -0.5f}, 4.5f};
  scene.throws = {{0.4, {0.9, 1.5, 6}, {-1.0, 0.8, -24}}, {1.5, {-1.6, 1.2, 6}, {2.4, 0.2, -24}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
