// KHR_physics_rigid_bodies as of January 2026 (Review Draft): colliders refer to a mesh, not to a node.
// Readers that know only the older version (geometry.node) see bodies without shapes.
#pragma once

#include "common/fragment/fragments.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

/// Writes the document's member "KHR_physics_rigid_bodies": a physics material (always present, because Babylon's
/// loader rejects the asset without it) and those of parts made of other materials, and the collision filters of fragments whose hulls overlap
/// (physics/collision_filters.hpp).
void write_khr_physics_document(JsonText& json, const SceneLayout& layout, const GltfOptions& options);

/// Writes the member "KHR_physics_rigid_bodies" of a fragment's node. The motion always has mass, centerOfMass
/// (local), inertiaDiagonal and inertiaOrientation, because engines assume unit inertia if none is given. The
/// collider is included if the fragment has a single hull.
void write_khr_physics_body(JsonText& json, const Fragment& fragment, std::size_t index,
                            const SceneLayout& layout, const GltfOptions& options);

/// Writes the same member for a compound's child node: one convex collider with the hull mesh.
void write_khr_physics_collider(JsonText& json, const Fragment& f, std::size_t fragment, std::size_t hull,
                                const SceneLayout& layout, const GltfOptions& options);

/// Writes the same member for a node that does not move: one convex collider with this mesh.
void write_khr_physics_static_collider(JsonText& json, const Fragment& f, std::size_t mesh,
                                       const GltfOptions& options);

}  // namespace fracture
