// A breakable mesh: the file for the server, the model to draw, and the shapes for physics while it is whole.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/render/model.hpp"
#include "client/scenes/solid_shapes.hpp"
#include "client/world/world.hpp"
#include "common/base/error.hpp"

namespace fracture::scenes {

struct MeshAsset {
  std::string name;
  std::string bytes;  ///< GLB or glTF
  std::string content_type = "model/gltf-binary";
  std::string unit;  ///< of the coordinates in `bytes`, in the server's words; empty: as stated in the file
  std::shared_ptr<const render::Model> model;
  std::vector<world::Hull> hulls;     ///< of the whole mesh, or of its slices; at most 64 points each
  world::MassProperties unit_mass;    ///< at 1 kg/m³
  glm::dvec3 low{0}, high{0};         ///< bounding box
  std::vector<std::string> warnings;  ///< differences from the file
};

/// `cuts`: ascending heights between which the mesh is nearly convex.
MeshAsset make_asset(const SurfaceMesh& mesh, const std::string& name, const glm::vec4& color,
                     const std::vector<float>& cuts = {});

/// Reads any file that common/import can read. GLB is sent unchanged, with `unit` (m, cm, mm or inch). If
/// `unit` is empty, it is guessed: centimetres if metres would make the mesh longer than 12 m, millimetres if
/// centimetres still would. Other formats are sent as a GLB of their triangles with normals and base colours,
/// so that the server does not need to read them. Their units and axes are those of the file. A mesh larger
/// than 4 m or smaller than 0.2 m is scaled to 2 m. kMalformedMesh and the errors of common/import.
Expected<MeshAsset> load_asset(const std::string& path, const std::string& unit = {});

/// Path of Blender's monkey if assimp-testmodels is installed, otherwise empty.
std::string monkey_path();

}  // namespace fracture::scenes
