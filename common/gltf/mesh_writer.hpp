// The meshes of the file: fragments with all their attributes, and collision hulls with positions alone.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/gltf/accessors.hpp"
#include "common/gltf/json_text.hpp"
#include "common/physics/collision_hulls.hpp"

namespace fracture {

class MeshWriter {
 public:
  MeshWriter(const MaterialLibrary& library, const nlohmann::json& interior_material, bool mesh_manifold,
             Accessors& accessors);

  /// Attribute accessors shared by the primitives, indices of all of them in one run.
  void write(JsonText& json, const Fragment& fragment, const std::string& name);
  /// One primitive without a material. Throws InternalError when a triangle names a point that is not there.
  void write(JsonText& json, const CollisionHull& hull, const std::string& name);

 private:
  bool needs_tangents(const FragmentPrimitive& p) const;
  /// Returns the accessor.
  std::size_t write_positions(const std::vector<Vec3f>& positions);

  Accessors& accessors_;
  bool mesh_manifold_;
  std::size_t interior_ = 0;
  std::vector<bool> normal_mapped_;
  std::vector<std::pair<std::string, std::size_t>> attributes_;  ///< of the mesh that is written: accessors
};

}  // namespace fracture
