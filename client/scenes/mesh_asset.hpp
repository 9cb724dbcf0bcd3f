// A mesh that can be broken: what the server is sent, what is drawn, and what physics takes it for while it
// is whole.
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
  std::string unit;  ///< of the coordinates in `bytes`, as the server calls it; empty: as the file says
  std::shared_ptr<const render::Model> model;
  std::vector<world::Hull> hulls;     ///< of all of it, or of its slices; at most 64 points each
  world::MassProperties unit_mass;    ///< at 1 kg/m³
  glm::dvec3 low{0}, high{0};         ///< box
  std::vector<std::string> warnings;  ///< what is not as in the file
};

/// `cuts`: heights between which the mesh is nearly convex, ascending.
MeshAsset make_asset(const SurfaceMesh& mesh, const std::string& name, const glm::vec4& color,
                     const std::vector<float>& cuts = {});

/// Any file that common/import reads. GLB is sent as it is, with `unit` (m, cm, mm, inch; empty: a guess, for nobody
/// means a chair of 80 m: centimetres where metres make it larger than 12 m, millimetres where these still do). Other formats are read here and sent as a GLB of
/// their triangles with normals and base colours, so that the server needs none of their readers. Units and
/// axes as the file says; a mesh larger than 4 m or smaller than 0.2 m is scaled to 2 m. kMalformedMesh and
/// whatever common/import refuses.
Expected<MeshAsset> load_asset(const std::string& path, const std::string& unit = {});

/// Path of Blender's monkey where assimp-testmodels is installed; empty where it is not.
std::string monkey_path();

}  // namespace fracture::scenes
