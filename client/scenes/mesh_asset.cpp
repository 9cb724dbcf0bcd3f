#include "client/scenes/mesh_asset.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <iterator>

#include "common/import/import.hpp"
#include "common/mesh/frame.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/proxies.hpp"

namespace fracture::scenes {
namespace {

namespace fs = std::filesystem;

constexpr float kLargest = 12;  ///< metres: the greatest plausible length of a mesh with unknown unit

float metres_of(const std::string& unit) {
  return unit == "cm" ? 0.01f : unit == "mm" ? 0.001f : unit == "inch" ? 0.0254f : 1.f;
}

/// The unit in which an object of this length has a size that people throw balls at.
std::string guessed_unit(float length) {
  return length <= kLargest ? "" : length <= 100 * kLargest ? "cm" : "mm";
}

Expected<MeshAsset> complete(MeshAsset asset, const std::vector<float>& cuts = {}, bool guess = false) {
  auto model = render::read_model(std::as_bytes(std::span(asset.bytes.data(), asset.bytes.size())));
  if (!model) return fail(model.error().code, to_string(model.error()));
  std::vector<glm::vec3> positions;
  positions.reserve(model->vertices.size());
  for (const render::Vertex& v : model->vertices)
    positions.emplace_back(model->objects[v.object].transform * glm::vec4(v.position, 1));
  if (guess && asset.unit.empty()) {
    glm::vec3 low(HUGE_VALF), high(-HUGE_VALF);
    for (const glm::vec3& p : positions) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    const glm::vec3 size = high - low;
    asset.unit = guessed_unit(std::max({size.x, size.y, size.z}));
    if (!asset.unit.empty())
      asset.warnings.push_back(asset.name + " is assumed to be in " + asset.unit +
                               " (use --unit or the key U to change this).");
  }
  if (const float scale = metres_of(asset.unit); scale != 1) {
    for (glm::vec3& p : positions) p *= scale;
    for (render::Object& object : model->objects)
      object.transform = glm::scale(glm::mat4(1), glm::vec3(scale)) * object.transform;
  }
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t k = 0; k + 2 < model->indices.size(); k += 3)
    triangles.push_back({model->indices[k], model->indices[k + 1], model->indices[k + 2]});
  asset.unit_mass = world::solid_mass(positions, triangles, 1);
  for (std::size_t k = 0; k <= cuts.size(); ++k) {
    const float from = k == 0 ? -HUGE_VALF : cuts[k - 1], to = k == cuts.size() ? HUGE_VALF : cuts[k];
    std::vector<glm::vec3> slice;
    for (const glm::vec3& p : positions)
      if (p.y >= from && p.y <= to) slice.push_back(p);
    asset.hulls.push_back(world::reduced_hull(slice));
    if (asset.hulls.back().size() < 4)
      return fail(ErrorCode::kEmptyMesh, "The mesh has fewer than four vertices.");
  }
  asset.low = glm::dvec3(HUGE_VAL);
  asset.high = -asset.low;
  for (const glm::vec3& p : positions) {
    asset.low = glm::min(asset.low, glm::dvec3(p));
    asset.high = glm::max(asset.high, glm::dvec3(p));
  }
  asset.warnings.insert(asset.warnings.end(), model->warnings.begin(), model->warnings.end());
  asset.model = std::make_shared<const render::Model>(std::move(*model));
  return asset;
}

SurfaceMesh surface_of(const Mesh& mesh) {
  SurfaceMesh surface;
  const bool smooth = mesh.attributes.normals.size() == mesh.positions.size();
  glm::vec3 low(HUGE_VALF), high(-HUGE_VALF);
  for (const Vec3f& p : mesh.positions) {
    low = glm::min(low, {p.x, p.y, p.z});
    high = glm::max(high, {p.x, p.y, p.z});
  }
  const glm::vec3 size = high - low;
  const float longest = std::max({size.x, size.y, size.z});
  const float scale = longest > 4 || longest < 0.2f ? 2 / std::max(longest, 1e-6f) : 1;
  const glm::vec3 middle(0.5f * (low + high));
  const auto position = [&](std::uint32_t v) {
    const Vec3f& p = mesh.positions[v];
    return scale * (glm::vec3(p.x, p.y, p.z) - middle);
  };
  for (const auto& t : mesh.triangles) {
    if (!smooth) {
      const glm::vec3 n = glm::cross(position(t[1]) - position(t[0]), position(t[2]) - position(t[0]));
      if (glm::dot(n, n) > 0) surface.triangle(position(t[0]), position(t[1]), position(t[2]));
      continue;
    }
    surface.triangles.push_back(t);
  }
  if (smooth)
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const Vec3f& n = mesh.attributes.normals[v];
      surface.positions.push_back(position(v));
      surface.normals.emplace_back(n.x, n.y, n.z);
    }
  return surface;
}

}  // namespace

MeshAsset make_asset(const SurfaceMesh& mesh, const std::string& name, const glm::vec4& color,
                     const std::vector<float>& cuts) {
  MeshAsset asset;
  asset.name = name;
  asset.bytes = to_glb(mesh, name, color);
  Expected<MeshAsset> made = complete(std::move(asset), cuts);
  if (!made) throw InternalError("The built-in mesh " + name + ": " + made.error().detail);
  return std::move(*made);
}

Expected<MeshAsset> load_asset(const std::string& path, const std::string& unit) {
  std::ifstream in(path, std::ios::binary);
  MeshAsset asset;
  asset.unit = unit;
  asset.name = fs::path(path).stem().string();
  asset.bytes.assign(std::istreambuf_iterator<char>(in), {});
  if (!in.is_open() || in.bad()) return fail(ErrorCode::kMalformedMesh, "Cannot read " + path + ".");
  std::string extension = fs::path(path).extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto format = format_from_extension(extension);
  if (!format)
    return fail(ErrorCode::kUnknownFormat,
                path + " does not have the file extension of a supported mesh format.");
  if (*format == MeshFormat::kGlb) return complete(std::move(asset), {}, true);
  // Files that the mesh refers to are in the same folder.
  std::vector<std::string> names, contents;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(fs::path(path).parent_path(), ignored)) {
    constexpr std::uintmax_t kLargestFile = 64u << 20;
    if (names.size() >= 64 || !entry.is_regular_file(ignored) || entry.file_size(ignored) > kLargestFile)
      continue;
    const std::string beside = entry.path().extension().string();
    if (beside != ".bin" && beside != ".mtl" && beside != ".png" && beside != ".jpg") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    names.push_back(entry.path().filename().string());
    contents.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  std::vector<ImportFile> files;
  for (std::size_t k = 0; k < names.size(); ++k)
    files.push_back({names[k], std::as_bytes(std::span(contents[k].data(), contents[k].size()))});
  Expected<Mesh> mesh = import_mesh(std::as_bytes(std::span(asset.bytes.data(), asset.bytes.size())), *format,
                                    ImportLimits{}, files);
  if (!mesh) return tl::unexpected(mesh.error());
  to_metres_y_up(*mesh, {});
  take_proxies(*mesh);
  const SurfaceMesh surface = surface_of(*mesh);
  glm::vec4 color(0.6f, 0.58f, 0.55f, 1);
  if (!mesh->library->materials.empty()) {
    const nlohmann::json& material = mesh->library->materials.front();
    const nlohmann::json factor =
        material.value("/pbrMetallicRoughness/baseColorFactor"_json_pointer, nlohmann::json());
    if (factor.is_array() && factor.size() == 4)
      for (int k = 0; k < 4; ++k) color[k] = factor[static_cast<std::size_t>(k)].get<float>();
  }
  asset.bytes = to_glb(surface, asset.name, color);
  asset.unit.clear();  // the coordinates are now in metres
  asset.warnings.push_back(path + " is shown and sent without its textures.");
  return complete(std::move(asset));
}

std::string monkey_path() {
  constexpr const char* kMonkey = "/usr/share/assimp/models/BLEND/Suzanne_248.blend";
  return fs::exists(kMonkey) ? kMonkey : "";
}

}  // namespace fracture::scenes
