// Nodes of a source that stand for another node: its levels of detail and its collision geometry.
#pragma once

#include "common/base/execution.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Treatment of nodes that stand for another node.
enum class Proxies {
  kHulls,  ///< levels of detail are left out, and collision geometry becomes Mesh::given_hulls (the default)
  kGeometry,  ///< they are like all other nodes
};

/// Takes the following nodes out of the mesh and its passed_through, if the node that they belong to (the owner) has triangles
/// in the mesh. Names are those of the nodes themselves.
///
/// - Levels of detail: "Crate_LOD1" if there is a "Crate_LOD0". They are added to Mesh::dropped.
/// - Collision geometry, by Unreal's names (UCX_Crate, UCX_Crate_00; UBX_, USP_ and UCP_) and Godot's (Crate-col, Crate-convcol,
///   Crate-colonly, Crate-convcolonly; also with $ or, except for -col, with _). The owner or a node above it is called "Crate"
///   or "Crate_LOD0". It is added to Mesh::given_hulls, and to Mesh::dropped, because the fragments do not have it.
/// - "Crate-colonly" and "Crate-convcolonly" without an owner, because they are never visible. They are added to Mesh::dropped.
///   But if the mesh had no other triangles, they would stay.
///
/// The entries, and warnings about collision geometry, name the parameter `proxies`. A mesh without such nodes does not change.
/// Throws Interrupted; the mesh then has lost some of its parts.
void take_proxies(Mesh& mesh, const Execution& execution = kUninterrupted);

}  // namespace fracture
