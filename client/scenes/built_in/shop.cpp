#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

using render::SolidLook;

namespace {

SurfaceMesh turned_profile(std::vector<glm::vec2> profile) {
  Turned shape;
  shape.segments = 32;
  shape.profile = std::move(profile);
  return turned(shape);
}

/// The vase of the other scenes in another size.
SurfaceMesh small_vase(float scale) {
  SurfaceMesh mesh = vase();
  for (glm::vec3& p : mesh.positions) p *= scale;
  return mesh;
}

/// Outside from the foot upwards, over the rim, and down inside; metres.
SurfaceMesh bottle() {
  return turned_profile({{0.040f, 0.000f},
                         {0.044f, 0.010f},
                         {0.044f, 0.170f},
                         {0.036f, 0.205f},
                         {0.017f, 0.240f},
                         {0.015f, 0.300f},
                         {0.018f, 0.305f},
                         {0.018f, 0.315f},
                         {0.011f, 0.315f},
                         {0.010f, 0.245f},
                         {0.030f, 0.205f},
                         {0.038f, 0.168f},
                         {0.038f, 0.014f}});
}

SurfaceMesh bowl() {
  return turned_profile({{0.045f, 0.000f},
                         {0.050f, 0.012f},
                         {0.085f, 0.035f},
                         {0.120f, 0.085f},
                         {0.124f, 0.095f},
                         {0.116f, 0.095f},
                         {0.078f, 0.043f},
                         {0.040f, 0.022f}});
}

SurfaceMesh plate() {
  return turned_profile({{0.060f, 0.000f},
                         {0.064f, 0.006f},
                         {0.125f, 0.022f},
                         {0.127f, 0.027f},
                         {0.075f, 0.014f},
                         {0.050f, 0.013f}});
}

}  // namespace

Scene shop() {
  Scene scene;
  scene.title = "A shelf of vases, bottles, bowls and plates";
  const double width = 2.4, depth = 0.42, board = 0.03, shelf_height = 0.62, foot = 0.35;
  constexpr int kShelves = 3;
  const auto tall_vase = share(make_asset(small_vase(0.26f), "vase", {0.25f, 0.35f, 0.55f, 1})),
             wide_vase = share(make_asset(small_vase(0.19f), "vase", {0.6f, 0.32f, 0.2f, 1})),
             glass = share(make_asset(bottle(), "bottle", {0.55f, 0.75f, 0.6f, 1})),
             dish = share(make_asset(bowl(), "bowl", {0.8f, 0.76f, 0.66f, 1})),
             disc = share(make_asset(plate(), "plate", {0.85f, 0.85f, 0.83f, 1}));
  const auto put = [&](const auto& mesh, const char* name, double x, double y, double z,
                       const char* material) {
    SceneObject object;
    object.name = name;
    object.mesh = mesh;
    object.pose = at(x, y, z);
    scene.objects.push_back(object);
    set_material(scene.objects.back(), material);
    scene.objects.back().breakage.sites = 45;
  };
  const double above = 0.001;
  for (int shelf = 0; shelf < kShelves; ++shelf) {
    const double y = foot + shelf * shelf_height;
    scene.boxes.push_back({at(0, y - board / 2, 0), {width / 2, board / 2, depth / 2}, SolidLook::kWood});
    const double top = y + above;
    if (shelf == 0)
      for (int k = 0; k < 6; ++k) {
        const double x = -0.95 + 0.38 * k;
        if (k % 2 == 0)
          for (int p = 0; p < 4; ++p) put(disc, "plate", x, top + 0.0285 * p, 0, "ceramic");
        else
          put(dish, "bowl", x, top, 0.02, "ceramic");
      }
    if (shelf == 1)
      for (int k = 0; k < 9; ++k)
        put(glass, "bottle", -0.92 + 0.23 * k, top, k % 2 == 0 ? -0.05 : 0.06, "glass");
    if (shelf == 2)
      for (int k = 0; k < 5; ++k)
        put(k % 2 == 0 ? tall_vase : wide_vase, "vase", -0.9 + 0.45 * k, top, 0, "ceramic");
  }
  const double high = foot + (kShelves - 1) * shelf_height;
  for (const double side : {-1.0, 1.0})
    scene.boxes.push_back({at(side * (width / 2 + board / 2), high / 2, 0),
                           {board / 2, high / 2, depth / 2},
                           SolidLook::kWood});
  scene.ball_radius = 0.08;
  scene.ball_density = 7800;
  scene.ball_speed = 10;
  scene.eye = {1.05f, 1.55f, 2.3f};
  scene.target = {0.05f, 1.06f, 0};
  scene.bounds = {{0, 1, 0}, 2.6f};
  scene.throws = {{0.3, {0.5, 1.5, 4}, {-0.5, 1.0, -10}},
                  {0.9, {-0.6, 1.7, 4}, {0.4, 2.0, -10}},
                  {1.0, {0.9, 1.7, 4}, {-1.1, 2.0, -10}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
