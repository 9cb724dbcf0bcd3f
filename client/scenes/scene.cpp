#include "client/scenes/scene.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "client/scenes/built_in/built_in.hpp"
#include "common/import/formats.hpp"

namespace fracture::scenes {
namespace {

namespace fs = std::filesystem;
using render::SolidLook;

using built_in::at;
using built_in::share;

struct BuiltIn {
  const char* name;
  Expected<Scene> (*make)();
};

constexpr BuiltIn kBuiltIn[] = {
    {"monkey", built_in::monkey},
    {"panes", [] { return Expected<Scene>(built_in::panes()); }},
    {"shop", [] { return Expected<Scene>(built_in::shop()); }},
    {"wall", [] { return Expected<Scene>(built_in::wall()); }},
    {"concrete", [] { return Expected<Scene>(built_in::concrete()); }},
    {"temple", [] { return Expected<Scene>(built_in::temple()); }},
    {"building", [] { return Expected<Scene>(built_in::building()); }},
    {"crates", [] { return Expected<Scene>(built_in::crates()); }},
    {"ice", [] { return Expected<Scene>(built_in::ice()); }},
};

}  // namespace

View view_at(const Scene& scene, double seconds) {
  if (!scene.closer) return {scene.eye, scene.target};
  const CameraMove& move = *scene.closer;
  const double share = std::clamp((seconds - move.from) / (move.until - move.from), 0.0, 1.0);
  const auto smooth = static_cast<float>(share * share * (3 - 2 * share));
  return {glm::mix(scene.eye, move.to.eye, smooth), glm::mix(scene.target, move.to.target, smooth)};
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const BuiltIn& scene : kBuiltIn) names.emplace_back(scene.name);
  return names;
}

Expected<Scene> make_scene(const std::string& name) {
  std::string known;
  for (const BuiltIn& built : kBuiltIn) {
    known += (known.empty() ? "" : ", ") + std::string(built.name);
    if (name != built.name) continue;
    Expected<Scene> scene = built.make();
    if (scene) scene->name = name;
    return scene;
  }
  return fail(ErrorCode::kBadParameter, "There is no scene '" + name + "' (" + known + ").", "scene");
}

namespace {

/// The mesh files among the paths. Those in folders are sorted by name.
std::vector<std::string> mesh_files(const std::vector<std::string>& paths) {
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
  return files;
}

/// Places the objects 1.5 m above the ground, in rows that form about a square, with low objects in front.
/// Returns half the width, the depth and the height of them all.
glm::dvec3 lay_out(std::vector<SceneObject>& objects) {
  constexpr double kAbove = 1.5, kGap = 0.5;  // metres
  const auto size = [](const SceneObject& object) { return object.mesh->high - object.mesh->low; };
  std::stable_sort(objects.begin(), objects.end(),
                   [&](const SceneObject& a, const SceneObject& b) { return size(a).y < size(b).y; });
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(objects.size()))));
  glm::dvec3 all(0);
  for (std::size_t first = 0; first < objects.size(); first += columns) {
    const std::size_t end = std::min(first + columns, objects.size());
    double width = -kGap, depth = 0;
    for (std::size_t k = first; k < end; ++k) {
      width += size(objects[k]).x + kGap;
      depth = std::max(depth, size(objects[k]).z);
    }
    double x = -width / 2;
    for (std::size_t k = first; k < end; ++k) {
      const MeshAsset& mesh = *objects[k].mesh;
      const glm::dvec3 middle = 0.5 * (mesh.low + mesh.high);
      objects[k].pose =
          at(x + size(objects[k]).x / 2 - middle.x, kAbove - mesh.low.y, -all.y - depth / 2 - middle.z);
      x += size(objects[k]).x + kGap;
      all.z = std::max(all.z, kAbove + size(objects[k]).y);
    }
    all.x = std::max(all.x, width / 2);
    all.y += depth + kGap;
  }
  return all;
}

}  // namespace

Expected<Scene> scene_of_files(const std::vector<std::string>& paths, const std::string& unit) {
  constexpr std::size_t kMost = 40;
  Scene scene;
  scene.name = "files";
  for (const std::string& file : mesh_files(paths)) {
    if (scene.objects.size() >= kMost) {
      scene.warnings.push_back("There are more than " + std::to_string(kMost) +
                               " meshes; the others are ignored.");
      break;
    }
    Expected<MeshAsset> asset = load_asset(file, unit);
    if (!asset) {
      scene.warnings.push_back(file + ": " + asset.error().detail);
      continue;
    }
    for (const std::string& warning : asset->warnings) scene.warnings.push_back(warning);
    SceneObject object;
    object.name = asset->name;
    object.mesh = share(std::move(*asset));
    scene.objects.push_back(std::move(object));
  }
  if (scene.objects.empty())
    return fail(ErrorCode::kEmptyMesh,
                scene.warnings.empty() ? "No mesh file was given or found." : scene.warnings.front());
  const glm::dvec3 all = lay_out(scene.objects);
  set_material(scene, "ceramic");
  for (SceneObject& object : scene.objects) object.look = SolidLook::kNone;  // files have their own look
  // From the front and above, far enough away to see everything.
  const auto half = static_cast<float>(all.x), deep = static_cast<float>(all.y),
             high = static_cast<float>(all.z);
  const float reach = std::max({2 * half, high, deep});
  scene.title = std::to_string(scene.objects.size()) + " meshes from files";
  scene.target = {0, 0.4f * high, -0.4f * deep};
  scene.eye = {0.3f * half, 0.5f * high + 0.25f * deep + 0.4f, 1.1f * std::max(1.2f * half, high) + 0.5f};
  scene.bounds = {{0, 0.4f * high, -0.5f * deep}, reach + 1};
  const glm::dvec3 from(scene.eye), to(scene.target);
  scene.throws = {{2.0, from, 13.0 * glm::normalize(to - from) + glm::dvec3(0, 1, 0)}};
  return scene;
}

}  // namespace fracture::scenes
