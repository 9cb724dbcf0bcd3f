#include "client/scenes/built_in/built_in.hpp"

namespace fracture::scenes::built_in {

using render::SolidLook;

Scene panes() {
  Scene scene;
  scene.title = "A row of glass panes";
  const double width = 1.3, height = 1.8, depth = 0.025, frame = 0.07, foot = 0.25;
  const auto mesh = share(make_asset(box(glm::vec3(width, height, depth)), "pane", {0.85f, 0.95f, 0.93f, 1}));
  // Points along the border, where the frame holds the pane.
  nlohmann::json held = nlohmann::json::array();
  const auto hold = [&](double x, double y) { held.push_back(nlohmann::json::array({x, y, 0})); };
  constexpr int kSteps = 8;
  for (int k = 0; k <= kSteps; ++k) {
    const double t = 2.0 * k / kSteps - 1;
    for (const double side : {-1.0, 1.0}) {
      hold(t * (width / 2 - 0.01), side * (height / 2 - 0.01));
      hold(side * (width / 2 - 0.01), t * (height / 2 - 0.01));
    }
  }
  constexpr int kPanes = 5;
  for (int k = 0; k < kPanes; ++k) {
    const double x = (k - (kPanes - 1) / 2.0) * (width + 2 * frame + 0.12), y = foot + frame + height / 2;
    SceneObject object;
    object.name = "pane " + std::to_string(k + 1);
    object.mesh = mesh;
    object.pose = at(x, y, 0);
    object.held = true;
    object.breakage.parameters["anchor_points"] = held;
    scene.objects.push_back(object);
    const double sides = width / 2 + frame / 2, ends = height / 2 + frame / 2;
    for (const double s : {-1.0, 1.0}) {
      scene.boxes.push_back({at(x + s * sides, y, 0), {frame / 2, ends + frame / 2, 0.05}, SolidLook::kNone});
      scene.boxes.push_back({at(x, y + s * ends, 0), {width / 2, frame / 2, 0.05}, SolidLook::kNone});
      scene.boxes.push_back({at(x + s * sides, foot / 2, 0), {0.05, foot / 2, 0.22}, SolidLook::kNone});
    }
  }
  set_material(scene, "glass");
  for (SceneObject& object : scene.objects) {
    object.strength = 6;
    object.breakage.parameters["merge"] = 0.3;  // shards must not all reach the frame, which would hold them
    object.breakage.parameters["bond_strength"] = 20e6;  // a scratched pane
  }
  scene.ball_radius = 0.09;
  scene.ball_speed = 14;
  scene.eye = {2.5f, 1.9f, 3.0f};
  scene.target = {0.55f, 1.0f, 0};
  scene.bounds = {{0, 1, 0}, 5};
  scene.throws = {{0.3, {0.3, 1.6, 6}, {-0.2, 1.2, -15}}, {2.2, {2.2, 1.8, 6}, {-1.2, 0.9, -15}}};
  return scene;
}

}  // namespace fracture::scenes::built_in
