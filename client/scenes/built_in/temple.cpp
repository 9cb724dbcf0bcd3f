#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

using render::SolidLook;

namespace {

SurfaceMesh column(float height) {
  Turned shape;
  shape.segments = 48;
  shape.flutes = 12;
  shape.groove = 0.03f;
  shape.profile = {{0.42f, 0.0f},  {0.42f, 0.12f}, {0.40f, 0.14f},
                   {0.41f, 0.20f}, {0.34f, 0.24f}, {0.33f, 0.30f}};
  shape.fluted_from = 0.29f;
  shape.fluted_to = height - 0.36f;
  constexpr int kRings = 5;
  for (int k = 1; k <= kRings; ++k) {  // entasis: the shaft is slightly curved
    const float t = static_cast<float>(k) / kRings;
    shape.profile.emplace_back(0.33f - 0.06f * t * t, 0.30f + t * (height - 0.68f));
  }
  for (const glm::vec2& p : {glm::vec2(0.29f, -0.35f),
                             {0.31f, -0.30f},
                             {0.29f, -0.27f},
                             {0.40f, -0.16f},
                             {0.43f, -0.14f},
                             {0.43f, 0.f}})
    shape.profile.emplace_back(p.x, height + p.y);
  return turned(shape);
}

}  // namespace

Scene temple() {
  Scene scene;
  scene.title = "A temple with columns";
  const float tall = 2.8f;
  const auto shaft =
      share(make_asset(column(tall), "column", {0.5f, 0.48f, 0.45f, 1}, {0.30f, tall - 0.38f}));
  const double step = 0.18, floor = 2 * step, dx = 1.7, dz = 1.5;
  for (int k = 0; k < 2; ++k)
    scene.boxes.push_back({at(0, (k + 0.5) * step, 0),
                           {dx + 1.15 - 0.3 * k, step / 2, dz + 1.15 - 0.3 * k},
                           SolidLook::kStone});
  for (int x = -1; x <= 1; ++x)
    for (const int z : {-1, 1}) {
      SceneObject object;
      object.name = "column";
      object.mesh = shaft;
      object.pose = at(x * dx, floor, z * dz);
      object.held = true;
      object.breakage.parameters["anchor_plane"] = ground_plane(0.05);
      scene.objects.push_back(object);
    }
  const auto beam = share(make_asset(box({1.7f, 0.36f, 0.62f}, 0.03f), "beam", {0.5f, 0.48f, 0.45f, 1}));
  const auto slab = share(make_asset(box({1.30f, 0.16f, 3.9f}, 0.03f), "slab", {0.5f, 0.48f, 0.45f, 1}));
  const double top = floor + tall;
  const auto add = [&](const char* name, const auto& mesh, double x, double y, double z) {
    SceneObject object;
    object.name = name;
    object.mesh = mesh;
    object.pose = at(x, y, z);
    scene.objects.push_back(object);
  };
  for (const int z : {-1, 1})
    for (const double x : {-0.5, 0.5}) add("beam", beam, x * dx * 1.01, top + 0.181, z * dz);
  for (int x = -1; x <= 1; ++x) add("slab", slab, x * 1.31, top + 0.361 + 0.082, 0);
  set_material(scene, "stone");
  for (SceneObject& object : scene.objects) {
    object.breakage.sites = object.held ? 45 : 20;
    if (object.held) object.strength = 150;
  }
  scene.ball_radius = 0.25;
  scene.ball_density = 7800;
  scene.ball_speed = 15;
  scene.eye = {4.4f, 2.6f, 6.0f};
  scene.target = {0, 1.75f, 0};
  scene.bounds = {{0, 1.8f, 0}, 6};
  scene.throws = {{0.3, {1.2, 2.2, 8}, {0.6, 0.4, -20}}, {1.2, {-5.5, 2.0, 6.5}, {11.0, 0.7, -13.8}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
