// Names and indices of the file's nodes and meshes. Nodes are in this order: the root, the fragments, the
// children of the fragments. Meshes: the fragments, then the shapes that instances share, then the hulls of both, then
// the fragments' sheets.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/gltf/json_text.hpp"
#include "common/physics/collision_filters.hpp"

namespace fracture {

/// Writes the translation of a root node: the offset of the source's positions (SourceFrame::offset). Writes nothing if it is
/// zero.
void write_offset(JsonText& json, const Mesh& source);

/// How the fragment's node places the shape of its instance; null if the fragment has its own mesh. Godot, which reads
/// OMI_physics_body, ignores the scale of a body, so scaled instances then have their own meshes.
const InstancedBodies::Body* instance_in_file(const FracturedSolid& fractured, const GltfOptions& options,
                                              std::size_t fragment);

class SceneLayout {
 public:
  /// Borrows FracturedSolid::rest. Throws Interrupted.
  SceneLayout(const FracturedSolid& fractured, const GltfOptions& options, const Execution& execution);

  const std::string& name(std::size_t fragment) const { return names_[fragment]; }
  /// Name of the hull's mesh and node: "UCX_<fragment>_00" for Unreal, otherwise "<fragment>_00_hull".
  std::string hull_name(std::size_t fragment, std::size_t hull) const;
  /// Returns "<fragment>_00_collider".
  std::string collider_name(std::size_t fragment, std::size_t hull) const;

  /// instance_in_file()
  const InstancedBodies::Body* instance(std::size_t fragment) const {
    return instance_.empty() ? nullptr : instance_[fragment];
  }
  std::size_t mesh(std::size_t fragment) const { return mesh_[fragment]; }
  /// The shapes in the file, as indices into InstancedBodies::shapes, with a fragment that names each.
  struct Shape {
    std::size_t index, fragment;
  };
  const std::vector<Shape>& shapes() const { return shapes_; }

  /// Number of the fragment's hulls. 0 if nothing in the file refers to them.
  std::size_t hulls(std::size_t fragment) const { return hull_count_[fragment]; }
  std::size_t hull_mesh(std::size_t fragment, std::size_t hull) const { return first_hull_[fragment] + hull; }
  /// Index of the hull among all hulls of the file.
  std::size_t hull_number(std::size_t fragment, std::size_t hull) const {
    return hull_mesh(fragment, hull) - first_hull_mesh();
  }
  /// Number of hull meshes.
  std::size_t hull_count() const { return hull_mesh_count_; }
  std::size_t first_hull_mesh() const { return first_hull_mesh_; }
  bool has_hulls() const { return hull_count() > 0; }

  /// The collision filters of the file. If it has none, the pointer is null.
  const CollisionFilters* filters() const { return filters_; }

  /// Number of child nodes with a collider: one per hull of a compound. A single hull's collider is on the fragment's node.
  std::size_t collider_nodes(std::size_t fragment) const {
    return physics_ && hulls(fragment) > 1 ? hulls(fragment) : 0;
  }
  std::size_t ucx_nodes(std::size_t fragment) const { return ucx_ ? hulls(fragment) : 0; }
  /// The node of the sheets that the fragment carries: the last of its children.
  std::size_t sheet_nodes(std::size_t fragment) const {
    return first_sheet_.empty() ? 0 : first_sheet_[fragment + 1] - first_sheet_[fragment];
  }
  std::size_t sheet_mesh(std::size_t fragment) const { return first_sheet_[fragment]; }
  /// Returns "<fragment>_sheet".
  std::string sheet_name(std::size_t fragment) const { return names_[fragment] + "_sheet"; }
  std::size_t children(std::size_t fragment) const {
    return collider_nodes(fragment) + ucx_nodes(fragment) + sheet_nodes(fragment);
  }
  std::size_t first_child(std::size_t fragment) const { return first_child_[fragment]; }

  /// Index of the first mesh, or node, after all of these.
  std::size_t mesh_count() const { return mesh_count_; }
  std::size_t node_count() const {
    return names_.empty() ? 1 : first_child_.back() + children(names_.size() - 1);
  }

 private:
  void number_meshes(const FracturedSolid& fractured, const GltfOptions& options);

  bool physics_, ucx_;
  const CollisionFilters* filters_ = nullptr;  // borrowed; only KHR_physics_rigid_bodies has filters
  std::size_t digits_ = 2;
  std::vector<std::string> names_;
  std::vector<const InstancedBodies::Body*> instance_;  // per fragment; borrowed
  std::vector<Shape> shapes_;
  std::vector<std::size_t> mesh_, first_hull_, hull_count_;  // per fragment: mesh indices, and a number
  std::size_t first_hull_mesh_ = 0, hull_mesh_count_ = 0, mesh_count_ = 0;
  std::vector<std::size_t>
      first_sheet_;  ///< mesh indices; one per fragment, and the end; empty if none carries any
  std::vector<std::size_t> first_child_;  ///< node index
};

}  // namespace fracture
