// The meshes of the file: fragments with all their attributes, and collision hulls with positions alone.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/gltf/accessors.hpp"
#include "common/gltf/exterior_material.hpp"
#include "common/gltf/interior_material.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/mesh_figures.hpp"
#include "common/physics/collision_hulls.hpp"

namespace fracture {

/// Writes their JSON, and puts their arrays into the contents of the buffer; it and the meshes are needed until those are
/// written.
class MeshWriter {
 public:
  /// The file has the materials of the library, then those of the interior and its cavities, then those of the exterior.
  MeshWriter(const MaterialLibrary& library, const InteriorMaterials& interior,
             const ExteriorMaterials& exterior, bool mesh_manifold, Accessors& accessors);

  /// Attribute accessors shared by the primitives, indices of all of them in one run.
  void write(JsonText& json, const Fragment& fragment, const MeshFigures& figures, const std::string& name);
  /// The same of what was not fractured: it keeps the source's materials.
  void write_whole(JsonText& json, const Fragment& mesh, const MeshFigures& figures, const std::string& name);
  /// One primitive without a material. Throws InternalError when a triangle names a point that is not there.
  void write(JsonText& json, const CollisionHull& hull, const std::string& name);

 private:
  void write(JsonText& json, const Fragment& fragment, const MeshFigures& figures, const std::string& name,
             const ExteriorMaterials& exterior);
  /// Index of a material of the file; none without a material.
  std::optional<std::size_t> material_of(const Fragment& fragment, const FragmentPrimitive& p,
                                         const ExteriorMaterials& exterior) const;
  /// Returns the accessor.
  std::size_t put_positions(const std::vector<Vec3f>& positions, const Bounds& bounds);
  void put_attributes(const Fragment& fragment, const MeshFigures& figures);
  /// Whether a primitive's material has a normal map, so that it needs tangents.
  bool is_mapped(std::size_t primitive) const {
    return materials_[primitive] && normal_mapped_[*materials_[primitive]];
  }

  Accessors& accessors_;
  bool mesh_manifold_;
  const InteriorMaterials& interior_;
  const ExteriorMaterials& exterior_;
  std::size_t first_interior_ = 0, first_exterior_ = 0;  ///< of the materials of the file
  std::vector<bool> normal_mapped_;
  std::deque<MovedUvs> moved_uvs_;
  // Of the mesh that is written: its attributes, and the material of each primitive.
  enum class Bearers { kAll, kMapped, kMappedCuts };
  struct Attribute {
    std::string semantic;
    std::size_t accessor;
    Bearers bearers = Bearers::kAll;  ///< primitives that have it
  };
  std::vector<Attribute> attributes_;
  std::vector<std::optional<std::size_t>> materials_;
};

}  // namespace fracture
