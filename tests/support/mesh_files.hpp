// The real meshes: files of the folders that FRACTURE_TEST_MESHES names, separated by ':' (default:
// ../shared/meshes/dev and unsound beside the source directory; the latter are those that fragments were once
// found open on). Where they are absent, tests skip; they never pass on nothing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

struct MeshFile {
  std::string name;  ///< relative path, e.g. "variants/barrel.gltf"
  std::string path;
};

/// The mesh files (glb gltf obj stl ply off fbx dae 3ds blend) of all folders, sorted by name; where two
/// folders have the same name, that of the first one alone. Empty where the folders are absent.
std::vector<MeshFile> test_meshes();
std::optional<MeshFile> find_test_mesh(const std::string& name);
/// Single closed files of the folder dev: edges all paired, consistently oriented, nothing to repair.
const std::vector<std::string>& closed_test_meshes();
/// Debian's assimp-testmodels, e.g. assimp_model("BLEND/Suzanne_248.blend"); nothing where the package is
/// absent.
std::optional<MeshFile> assimp_model(const std::string& name);

/// Loads through common/import. Without that library (early builds) OBJ files are read by a minimal reader of
/// our own and everything else is kUnknownFormat. The files it names beside itself are given to the importer.
Expected<Mesh> load_mesh(const MeshFile& file);

/// The minimal OBJ reader: positions and polygons (fans) only. The benchmark uses it so that it times no
/// importer.
Expected<Mesh> read_obj_positions(const std::string& path);

}  // namespace fracture::test
