#include "tests/support/mesh_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>

#ifdef FRACTURE_HAS_IMPORT
#include "common/import/import.hpp"
#include "common/import/sibling_files.hpp"
#endif

namespace fracture::test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> folders() {
  const char* set = std::getenv("FRACTURE_TEST_MESHES");
  std::istringstream names(set != nullptr ? set : FRACTURE_DEFAULT_TEST_MESHES);
  std::vector<fs::path> found;
  for (std::string name; std::getline(names, name, ':');)
    if (!name.empty()) found.emplace_back(name);
  return found;
}

std::string lower_extension(const fs::path& path) {
  std::string e = path.extension().string();
  std::transform(e.begin(), e.end(), e.begin(),
                 [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return e.empty() ? e : e.substr(1);
}

}  // namespace

std::vector<MeshFile> test_meshes() {
  std::map<std::string, std::string> paths;  // by name
  for (const fs::path& folder : folders()) {
    std::error_code error;
    for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      if (!it->is_regular_file()) continue;
      const std::string e = lower_extension(it->path());
      for (const char* known : {"glb", "gltf", "obj", "stl", "ply", "off", "fbx", "dae", "3ds", "blend"})
        if (e == known) paths.emplace(fs::relative(it->path(), folder).generic_string(), it->path().string());
    }
  }
  std::vector<MeshFile> files;
  for (const auto& [name, path] : paths) files.push_back({name, path});
  return files;
}

std::optional<MeshFile> find_test_mesh(const std::string& name) {
  for (const fs::path& folder : folders()) {
    std::error_code error;
    if (fs::is_regular_file(folder / name, error)) return MeshFile{name, (folder / name).string()};
  }
  return std::nullopt;
}

const std::vector<std::string>& closed_test_meshes() {
  static const std::vector<std::string> names{"Fox.glb",
                                              "cube.glb",
                                              "cube_uv.ply",
                                              "hammer.obj",
                                              "kenney-platformer/brick.glb",
                                              "kk_bottle_A_brown.glb",
                                              "kk_box_large.glb",
                                              "moon_ext_manifold.glb",
                                              "nested.glb",
                                              "penguin.obj",
                                              "round.stl",
                                              "spot.obj",
                                              "spot_quads.obj",
                                              "torus.obj"};
  return names;
}

std::optional<MeshFile> assimp_model(const std::string& name) {
  const fs::path path = fs::path("/usr/share/assimp/models") / name;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  return MeshFile{name, path.string()};
}

Expected<Mesh> load_mesh(const MeshFile& file) {
#ifdef FRACTURE_HAS_IMPORT
  std::ifstream in(file.path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const auto format = format_from_extension(lower_extension(file.path));
  if (!format) return fail(ErrorCode::kUnknownFormat, "No importer for " + file.name + ".");
  const auto view = std::as_bytes(std::span(bytes.data(), bytes.size()));
  const std::vector<SiblingFile> siblings = read_sibling_files(file.path, view, *format);
  return import_mesh(view, *format, {}, as_import_files(siblings));
#else
  if (lower_extension(file.path) == "obj") return read_obj_positions(file.path);
  return fail(ErrorCode::kUnknownFormat, "This build has no importer for " + file.name + ".");
#endif
}

Expected<Mesh> read_obj_positions(const std::string& path) {
  std::ifstream in(path);
  if (!in) return fail(ErrorCode::kEmptyBody, "Cannot open " + path + ".");
  Mesh mesh;
  std::string line, word;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "v") {
      Vec3f p;
      words >> p.x >> p.y >> p.z;
      mesh.positions.push_back(p);
    } else if (word == "f") {
      std::vector<std::uint32_t> polygon;
      while (words >> word) {
        const long index = std::strtol(word.c_str(), nullptr, 10);
        polygon.push_back(static_cast<std::uint32_t>(
            index > 0 ? index - 1 : static_cast<long>(mesh.positions.size()) + index));
      }
      for (std::size_t k = 2; k < polygon.size(); ++k)
        mesh.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
    }
  }
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.node.assign(mesh.triangles.size(), 0);
  mesh.node_names = {fs::path(path).stem().string()};
  return mesh;
}

}  // namespace fracture::test
