// The unbroken solid as a second scene. One file then has both objects that an engine swaps:
//
//   scene "Intact" ── root (identity; extras.intact: digest of the mesh)
//                      ├─ part 0  mesh with the source's materials; extras.intact: part, volume, mass; static collider
//                      │   └─ colliders of a part with several hulls, UCX_ hulls, sheets: identity, no extras
//                      ├─ part 1 …
//                      └─ parts that were not fractured: the same meshes as in the scene of the fragments
//
// No node here has extras.fracture, because readers recognize fragments by it. The default scene is that of the fragments.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/mesh_writer.hpp"
#include "common/gltf/passed_through.hpp"
#include "common/gltf/scene_layout.hpp"
#include "common/gltf/unique_names.hpp"

namespace fracture {

class IntactScene {
 public:
  /// The scene has no nodes or meshes if FracturedSolid::intact is not set. Its nodes and meshes follow those of the layout
  /// and `whole`. Throws Interrupted.
  IntactScene(const FracturedSolid& fractured, const GltfOptions& options, const SceneLayout& layout,
              const std::vector<WholeNode>& whole, const Execution& execution);

  bool is_empty() const { return names_.empty(); }
  std::size_t root() const { return first_node_; }
  /// Reserves the names of the scene's nodes and meshes.
  void take_names(UniqueNames& names) const;
  std::size_t node_count() const { return node_count_; }
  /// Index of the first hull mesh. The meshes of all hulls are consecutive; those of sheets follow them.
  std::size_t first_hull_mesh() const { return first_mesh_ + names_.size(); }
  std::size_t hull_count() const { return first_hull_.empty() ? 0 : first_hull_.back(); }

  /// Write elements of the arrays `nodes` and `meshes`. Throw Interrupted; write_meshes() also InternalError (MeshWriter).
  void write_nodes(JsonText& json, const GltfOptions& options) const;
  void write_meshes(JsonText& json, const GltfOptions& options, MeshWriter& writer) const;

 private:
  std::size_t hulls(std::size_t part) const { return first_hull_[part + 1] - first_hull_[part]; }
  std::size_t colliders(std::size_t part) const { return has_physics_ && hulls(part) > 1 ? hulls(part) : 0; }
  bool has_sheet(std::size_t part) const { return fractured_.intact->parts[part].sheet != nullptr; }
  std::size_t children(std::size_t part) const {
    return colliders(part) + (ucx_ ? hulls(part) : 0) + (has_sheet(part) ? 1 : 0);
  }
  std::string hull_name(std::size_t part, std::size_t hull) const;
  std::string collider_name(std::size_t part, std::size_t hull) const;
  void write_part(JsonText& json, std::size_t part, std::size_t first_child,
                  const GltfOptions& options) const;
  void write_collider(JsonText& json, std::size_t part, std::size_t hull, const GltfOptions& options) const;

  const FracturedSolid& fractured_;
  const Execution& execution_;
  const bool has_physics_, ucx_;
  std::size_t first_node_ = 0, node_count_ = 0;
  std::size_t first_mesh_ = 0, first_shape_ = 0;  ///< indices; the second in OMI_physics_shape
  std::size_t digits_ = 2;                        ///< of a hull's number
  std::string root_name_;  ///< "Intact", or "Intact_2" if a node that was not fractured has that name
  std::vector<std::string> names_;       ///< per part
  std::vector<std::size_t> first_hull_;  ///< one per part, and the end
  std::vector<std::string> whole_names_, whole_extras_;
  std::size_t first_whole_mesh_ = 0;
};

}  // namespace fracture
