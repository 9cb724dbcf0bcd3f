#include "client/scenes/scene.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/import/formats.hpp"

namespace fracture::scenes {
namespace {

namespace fs = std::filesystem;
using render::SolidLook;

std::shared_ptr<const MeshAsset> share(MeshAsset asset) {
  return std::make_shared<const MeshAsset>(std::move(asset));
}

world::Pose at(double x, double y, double z, double degrees = 0) {
  return {{x, y, z}, glm::angleAxis(glm::radians(degrees), glm::dvec3(0, 1, 0))};
}

/// What reaches below this height of its own frame is held.
nlohmann::json ground_plane(double height) {
  using nlohmann::json;
  return json::array({json::array({0, height, 0}), json::array({0, 1, 0})});
}

SurfaceMesh vase() {
  Turned shape;
  shape.segments = 48;
  // Outside from the foot up, over the rim, and down inside.
  shape.profile = {{0.30f, 0.0f},  {0.34f, 0.03f}, {0.30f, 0.10f}, {0.48f, 0.40f}, {0.58f, 0.75f},
                   {0.52f, 1.05f}, {0.30f, 1.35f}, {0.24f, 1.50f}, {0.30f, 1.66f}, {0.36f, 1.70f},
                   {0.30f, 1.68f}, {0.18f, 1.50f}, {0.24f, 1.33f}, {0.46f, 1.04f}, {0.51f, 0.75f},
                   {0.42f, 0.42f}, {0.24f, 0.14f}};
  return turned(shape);
}

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

Expected<Scene> monkey() {
  Scene scene;
  scene.title = "The monkey falls to the ground";
  SceneObject object;
  const std::string path = monkey_path();
  if (path.empty()) {
    scene.warnings.push_back("assimp-testmodels is not installed: a vase stands in for the monkey.");
    object.mesh = share(make_asset(vase(), "vase", {0.3f, 0.45f, 0.6f, 1}));
  } else {
    Expected<MeshAsset> loaded = load_asset(path);
    if (!loaded) return tl::unexpected(loaded.error());
    object.mesh = share(std::move(*loaded));
  }
  object.name = object.mesh->name;
  object.pose = {{0, 2.6 - object.mesh->low.y, 0},
                 glm::angleAxis(glm::radians(12.0), glm::normalize(glm::dvec3(1, 0.3, 0.4)))};
  scene.objects.push_back(std::move(object));
  set_material(scene, "ceramic");
  scene.eye = {2.4f, 2.2f, 5.2f};
  scene.target = {0, 1.5f, 0};
  scene.bounds = {{0, 1.8f, 0}, 5.5f};
  scene.throws = {{3.2, {5, 2.2, 6}, {-11.5, 0.5, -13}}};
  return scene;
}

Scene panes() {
  Scene scene;
  scene.title = "A row of glass panes";
  const double width = 1.3, height = 1.8, depth = 0.025, frame = 0.07, foot = 0.25;
  const auto mesh = share(make_asset(box(glm::vec3(width, height, depth)), "pane", {0.85f, 0.95f, 0.93f, 1}));
  // What the frame holds: points along the border.
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
  for (SceneObject& object : scene.objects) object.strength = 6;
  scene.ball_radius = 0.09;
  scene.ball_speed = 14;
  scene.eye = {3.0f, 1.8f, 3.9f};
  scene.target = {0.45f, 0.95f, 0};
  scene.bounds = {{0, 1, 0}, 5};
  scene.throws = {{0.3, {0.3, 1.6, 6}, {-0.2, 1.2, -15}}, {1.1, {2.2, 1.8, 6}, {-1.2, 0.9, -15}}};
  return scene;
}

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
  // Bricks and mortar are there from the start: bonds of the level, no request at the hit.
  SceneObject& bricks = scene.objects.front();
  bricks.at_start = true;
  bricks.breakage.parameters["cell"] = {0.4, 0.2, 0.3};
  bricks.breakage.parameters["bond"] = "half";
  bricks.bricks = {0.4f, 0.2f};
  scene.ball_radius = 0.22;
  scene.ball_density = 2600;
  scene.ball_speed = 13;
  scene.eye = {2.5f, 1.7f, 3.8f};
  scene.target = {0.1f, 1.05f, -0.3f};
  scene.bounds = {{0, 1, -0.5f}, 4.5f};
  scene.throws = {{0.3, {0.8, 1.5, 6}, {-1.0, 1.8, -13}}, {1.4, {-2.0, 1.2, 6}, {0.9, 1.6, -13}}};
  return scene;
}

Scene temple() {
  Scene scene;
  scene.title = "A temple of columns";
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
  scene.throws = {{0.3, {1.2, 2.2, 8}, {0.6, 0.6, -15}}, {1.2, {-5.5, 2.0, 6.5}, {8.8, 1.0, -11}}};
  return scene;
}

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

}  // namespace

std::vector<std::string> scene_names() { return {"monkey", "panes", "wall", "temple", "crates"}; }

Expected<Scene> make_scene(const std::string& name) {
  Expected<Scene> scene = Scene{};
  if (name == "monkey")
    scene = monkey();
  else if (name == "panes")
    scene = panes();
  else if (name == "wall")
    scene = wall();
  else if (name == "temple")
    scene = temple();
  else if (name == "crates")
    scene = crates();
  else
    return fail(ErrorCode::kBadParameter,
                "There is no scene '" + name + "' (monkey, panes, wall, temple, crates).", "scene");
  if (scene) scene->name = name;
  return scene;
}

Expected<Scene> scene_of_files(const std::vector<std::string>& paths) {
  constexpr std::size_t kMost = 40;
  Scene scene;
  scene.name = "files";
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    std::vector<std::string> inside;
    for (const auto& entry : fs::directory_iterator(path, error)) {
      const std::string extension = entry.path().extension().string();
      if (entry.is_regular_file(error) && extension.size() > 1 && format_from_extension(extension.substr(1)))
        inside.push_back(entry.path().string());
    }
    std::sort(inside.begin(), inside.end());
    files.insert(files.end(), inside.begin(), inside.end());
  }
  double x = 0;
  for (const std::string& file : files) {
    if (scene.objects.size() >= kMost) {
      scene.warnings.push_back("More than " + std::to_string(kMost) + " meshes: the rest is left out.");
      break;
    }
    Expected<MeshAsset> asset = load_asset(file);
    if (!asset) {
      scene.warnings.push_back(file + ": " + asset.error().detail);
      continue;
    }
    for (const std::string& warning : asset->warnings) scene.warnings.push_back(warning);
    SceneObject object;
    object.name = asset->name;
    object.mesh = share(std::move(*asset));
    const glm::dvec3 size = object.mesh->high - object.mesh->low,
                     middle = 0.5 * (object.mesh->low + object.mesh->high);
    object.pose = at(x + size.x / 2 - middle.x, 1.5 - object.mesh->low.y, -middle.z);
    x += size.x + 0.5;
    scene.objects.push_back(std::move(object));
  }
  if (scene.objects.empty())
    return fail(ErrorCode::kEmptyMesh,
                scene.warnings.empty() ? "No mesh file was given or found." : scene.warnings.front());
  const double all = x - 0.5;
  double high = 0;
  for (SceneObject& object : scene.objects) {
    object.pose.position.x -= all / 2;
    high = std::max(high, 1.5 + object.mesh->high.y - object.mesh->low.y);
  }
  set_material(scene, "ceramic");
  for (SceneObject& object : scene.objects) object.look = SolidLook::kNone;  // it has its own
  const auto reach = static_cast<float>(std::max(all, high));
  scene.title = std::to_string(scene.objects.size()) + " meshes from files";
  scene.target = {0, 0.4f * static_cast<float>(high), 0};
  scene.eye = {0.5f * reach, 0.3f * reach + 1, 1.3f * reach + 1.5f};
  scene.bounds = {{0, 0.4f * static_cast<float>(high), 0}, reach + 1};
  scene.throws = {{2.0, {0.5 * reach, 2, 1.3 * reach + 1.5}, {-0.5 * reach, 0.5, -1.3 * reach - 1.5}}};
  return scene;
}

}  // namespace fracture::scenes
