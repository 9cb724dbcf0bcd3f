#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

Scene crates() {
  Scene scene;
  scene.title = "A stack of crates";
  const float side = 0.8f;
  const auto mesh = share(make_asset(crate(side, 0.1f, 0.03f, 0.07f), "crate", {0.45f, 0.28f, 0.14f, 1}));
  constexpr int kRows = 4;
  for (int row = 0; row < kRows; ++row)
    for (int k = 0; k < kRows - row; ++k) {
      SceneObject object;
      object.name = "crate";
      object.mesh = mesh;
      const double turn = ((row * 7 + k * 5) % 5 - 2) * 1.5;  // nobody stacks crates straight
      object.pose =
          at((k - (kRows - 1 - row) / 2.0) * (side + 0.06), side / 2 + row * (side + 0.002) + 0.001, 0, turn);
      scene.objects.push_back(object);
    }
  set_material(scene, "wood");
  for (std::size_t k = 0; k < scene.objects.size(); ++k) {
    const glm::vec3 grains[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    scene.objects[k].grain = grains[k % 3];
    const glm::vec3& grain = grains[k % 3];
    scene.objects[k].breakage.parameters["grain"] = nlohmann::json::array({grain.x, grain.y, grain.z});
    scene.objects[k].strength = 120;
    scene.objects[k].breakage.sites = 22;
    scene.objects[k].look_scale = 0.5f;
  }
  scene.ball_radius = 0.16;
  scene.ball_speed = 17;
  scene.eye = {2.7f, 1.9f, 4.5f};
  scene.target = {0.1f, 1.3f, 0};
  scene.bounds = {{0, 1.3f, 0}, 4.5f};
  scene.throws = {{0.3, {1.0, 1.6, 7}, {-0.9, 0.9, -17}}, {1.3, {-1.5, 1.2, 7}, {1.8, 1.0, -17}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
