#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

Scene wall() {
  Scene scene;
  scene.title = "A brick wall";
  const double length = 4, height = 2.4, depth = 0.3;
  SceneObject object;
  object.name = "wall";
  object.mesh = share(make_asset(box(glm::vec3(length, height, depth)), "wall", {0.42f, 0.13f, 0.07f, 1}));
  object.pose = at(0, height / 2, 0);
  object.held = true;
  object.breakage.parameters["anchor_plane"] = ground_plane(-height / 2 + 0.01);
  scene.objects.push_back(object);
  set_material(scene, "brick");
  // Bricks and mortar exist from the start as bonds of the level, so a hit sends no request.
  SceneObject& bricks = scene.objects.front();
  bricks.at_start = true;
  bricks.breakage.parameters["cell"] = {0.4, 0.2, 0.3};
  bricks.breakage.parameters["bond"] = "half";
  bricks.bricks = {0.4f, 0.2f};
  scene.ball_radius = 0.22;
  scene.ball_density = 5000;
  scene.ball_speed = 14;
  scene.eye = {2.5f, 1.7f, 3.8f};
  scene.target = {0.1f, 1.05f, -0.3f};
  scene.bounds = {{0, 1, -0.5f}, 4.5f};
  scene.throws = {{0.3, {0.8, 1.5, 6}, {-1.0, 1.6, -15}}, {1.4, {-2.0, 1.2, 6}, {1.0, 1.4, -15}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
