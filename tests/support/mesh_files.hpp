// The real meshes: files of the folders in FRACTURE_TEST_MESHES, separated by ':'. The default is
// ../shared/meshes/dev and ../shared/meshes/unsound, next to the source directory. On the files of the
// second, fragments were once open. If the folders are absent, tests skip; they never pass without data.
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

/// The mesh files (glb gltf obj stl ply off fbx dae 3ds blend) of all folders, sorted by name. If two folders
/// contain a file of the same name, only that of the first folder is returned. Empty if the folders are
/// absent.
std::vector<MeshFile> test_meshes();
std::optional<MeshFile> find_test_mesh(const std::string& name);
/// Single closed files of the folder dev: all edges are paired, the orientation is consistent, and nothing
/// needs repair.
const std::vector<std::string>& closed_test_meshes();
/// A file of Debian's assimp-testmodels, e.g. assimp_model("BLEND/Suzanne_248.blend"). No value if the
/// package is absent.
std::optional<MeshFile> assimp_model(const std::string& name);

/// Loads a file through common/import. Without that library (early builds) our own minimal reader reads OBJ
/// files, and all other files are kUnknownFormat. The importer also gets the files that the mesh names.
Expected<Mesh> load_mesh(const MeshFile& file);

/// The minimal OBJ reader: only positions and polygons (fans). The benchmark uses it so that it times no
/// importer.
Expected<Mesh> read_obj_positions(const std::string& path);

}  // namespace fracture::test
