// Writes the meshes of the file: fragments with all their attributes, and collision hulls with positions only.
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

/// Writes the JSON of meshes and adds their arrays to the buffer's contents. The writer and the meshes must exist until the
/// buffer has been written.
class MeshWriter {
 public:
  /// Materials are in this order in the file: library, interior, cavities, exterior.
  MeshWriter(const MaterialLibrary& library, const InteriorMaterials& interior,
             const ExteriorMaterials& exterior, bool mesh_manifold, Accessors& accessors);

  /// Writes a fragment. Its primitives share their attribute accessors, and their indices are consecutive.
  void write(JsonText& json, const Fragment& fragment, const MeshFigures& figures, const std::string& name);
  /// Writes a mesh that was not fractured. It keeps the source's materials.
  void write_whole(JsonText& json, const Fragment& mesh, const MeshFigures& figures, const std::string& name);
  /// Writes a hull as one primitive without a material. Throws InternalError if a triangle has an index out of range.
  void write(JsonText& json, const CollisionHull& hull, const std::string& name);

 private:
  void write(JsonText& json, const Fragment& fragment, const MeshFigures& figures, const std::string& name,
             const ExteriorMaterials& exterior);
  /// Index of the primitive's material in the file; nothing if it has no material.
  std::optional<std::size_t> material_of(const Fragment& fragment, const FragmentPrimitive& p,
                                         const ExteriorMaterials& exterior) const;
  /// Returns the accessor's index.
  std::size_t put_positions(const std::vector<Vec3f>& positions, const Bounds& bounds);
  void put_attributes(const Fragment& fragment, const MeshFigures& figures);
  /// Whether a primitive's material has a normal map, so that it needs tangents.
  bool is_mapped(std::size_t primitive) const {
    return materials_[primitive] && normal_mapped_[*materials_[primitive]];
  }
  /// Writes the variants of a primitive that has this material of the file, if the source has any for it.
  void write_variants(JsonText& json, std::size_t material) const;

  Accessors& accessors_;
  bool mesh_manifold_;
  const MaterialLibrary& library_;
  const InteriorMaterials& interior_;
  const ExteriorMaterials& exterior_;
  std::size_t first_interior_ = 0, first_exterior_ = 0;  ///< indices of materials in the file
  std::vector<bool> normal_mapped_;                      ///< per material of the file: itself or in a variant
  std::deque<MovedUvs> moved_uvs_;
  // The mesh that is being written: its attributes, and the material of each primitive.
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
