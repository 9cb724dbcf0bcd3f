// Which names and indices the file's nodes and meshes have: nodes are the root, the fragments, then the
// children of the fragments in order; meshes are those of the fragments, then the hulls in order.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/gltf/gltf_writer.hpp"
#include "common/physics/collision_filters.hpp"

namespace fracture {

class SceneLayout {
 public:
  /// Borrows the rest of `fractured`. Throws Interrupted.
  SceneLayout(const FracturedSolid& fractured, const GltfOptions& options, const Execution& execution);

  const std::string& name(std::size_t fragment) const { return names_[fragment]; }
  /// Of mesh and node: "UCX_<fragment>_00" for Unreal, else "<fragment>_00_hull".
  std::string hull_name(std::size_t fragment, std::size_t hull) const;
  /// "<fragment>_00_collider"
  std::string collider_name(std::size_t fragment, std::size_t hull) const;

  /// Hull meshes of the fragment: 0 when nothing in the file refers to them.
  std::size_t hulls(std::size_t fragment) const { return first_hull_[fragment + 1] - first_hull_[fragment]; }
  std::size_t hull_mesh(std::size_t fragment, std::size_t hull) const { return first_hull_[fragment] + hull; }
  /// Among all hulls of the file.
  std::size_t hull_number(std::size_t fragment, std::size_t hull) const {
    return hull_mesh(fragment, hull) - names_.size();
  }
  std::size_t hull_count() const { return first_hull_.back() - first_hull_.front(); }
  bool has_hulls() const { return hull_count() > 0; }

  /// Null: there are none.
  const CollisionFilters* filters() const { return filters_; }

  /// A compound (several hulls) has its colliders on child nodes, one hull stands on the fragment's own node.
  std::size_t collider_nodes(std::size_t fragment) const {
    return physics_ && hulls(fragment) > 1 ? hulls(fragment) : 0;
  }
  std::size_t ucx_nodes(std::size_t fragment) const { return ucx_ ? hulls(fragment) : 0; }
  std::size_t children(std::size_t fragment) const { return collider_nodes(fragment) + ucx_nodes(fragment); }
  std::size_t first_child(std::size_t fragment) const { return first_child_[fragment]; }

  /// What follows behind all of these.
  std::size_t mesh_count() const { return first_hull_.back(); }
  std::size_t node_count() const {
    return names_.empty() ? 1 : first_child_.back() + children(names_.size() - 1);
  }

 private:
  bool physics_, ucx_;
  const CollisionFilters* filters_ = nullptr;  // borrowed; KHR_physics_rigid_bodies alone has them
  std::size_t digits_ = 2;
  std::vector<std::string> names_;
  std::vector<std::size_t> first_hull_;   ///< mesh index; one more than fragments
  std::vector<std::size_t> first_child_;  ///< node index
};

}  // namespace fracture
