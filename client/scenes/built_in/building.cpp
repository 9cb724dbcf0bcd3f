#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

Scene building() {
  Scene scene;
  scene.title = "A wrecking ball hits a building";
  const glm::vec3 slab_size(3.4f, 0.2f, 2.8f), wall_size(2.3f, 1.5f, 0.16f);
  const float post_side = 0.3f, post_height = 1.6f;
  const glm::vec4 grey(0.45f, 0.44f, 0.42f, 1);
  const auto post = share(make_asset(box({post_side, post_height, post_side}, 0.015f), "post", grey)),
             slab = share(make_asset(box(slab_size, 0.015f), "slab", grey)),
             wall = share(make_asset(box(wall_size, 0.01f), "wall", {0.5f, 0.46f, 0.4f, 1}));
  constexpr int kStoreys = 2;
  constexpr double kGap = 0.001;
  const double storey = post_height + slab_size.y + 2 * kGap;
  const auto put = [&](const auto& mesh, const char* name, const world::Pose& pose, bool held) {
    SceneObject object;
    object.name = name;
    object.mesh = mesh;
    object.pose = pose;
    object.held = held;
    if (held) object.breakage.parameters["anchor_plane"] = ground_plane(-post_height / 2 + 0.05);
    scene.objects.push_back(object);
  };
  const double x = slab_size.x / 2 - post_side / 2 - 0.05, z = slab_size.z / 2 - post_side / 2 - 0.05;
  for (int level = 0; level < kStoreys; ++level) {
    const double floor = level * storey;
    for (const double sx : {-1.0, 1.0})
      for (const double sz : {-1.0, 1.0})
        put(post, "post", at(sx * x, floor + post_height / 2, sz * z), level == 0);
    put(wall, "wall", at(0, floor + wall_size.y / 2 + kGap, -z), false);
    put(wall, "wall", at(-x, floor + wall_size.y / 2 + kGap, 0, 90), false);
    put(slab, "slab", at(0, floor + post_height + slab_size.y / 2 + kGap, 0), false);
  }
  set_material(scene, "concrete");
  for (SceneObject& object : scene.objects) {
    object.breakage.sites = object.name == "slab" ? 40 : 24;
    if (object.name == "slab") {  // a wide, thin slab is weak, so it breaks when it lands
      object.breakage.parameters["bond_strength"] = 1e6;
      object.strength *= 0.3;
    }
    if (object.held) object.strength = 120;
  }
  scene.ball_radius = 0.5;
  scene.ball_density = 5000;
  scene.ball_speed = 11;
  scene.eye = {5.2f, 3.0f, 6.2f};
  scene.target = {-0.1f, 1.6f, 0};
  scene.bounds = {{0, 1.8f, 0}, 6.5f};
  scene.throws = {{0.3, {4.5, 2.6, 6.5}, {-5.2, 1.5, -9}}, {2.0, {5.5, 1.4, 4}, {-9, 1.0, -5}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
