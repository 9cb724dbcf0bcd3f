// KHR_physics_rigid_bodies in its January 2026 form (Review Draft): colliders name a mesh, not a node.
// Readers that know only the older form (geometry.node) see bodies without shapes.
#pragma once

#include "common/fragment/fragments.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

/// The document's member "KHR_physics_rigid_bodies": one physics material (always there, because Babylon's
/// loader refuses the asset without it), and the collision filters of fragments whose hulls overlap
/// (physics/collision_filters.hpp).
void write_khr_physics_document(JsonText& json, const SceneLayout& layout, const GltfOptions& options);

/// The node's member "KHR_physics_rigid_bodies" of a fragment: motion with all four of mass, centerOfMass
/// (local), inertiaDiagonal and inertiaOrientation (engines take unit inertia where it is missing), and the
/// collider where it is one hull.
void write_khr_physics_body(JsonText& json, const Fragment& fragment, std::size_t index,
                            const SceneLayout& layout, const GltfOptions& options);

/// The same member of a compound's child node: one convex collider of the hull mesh.
void write_khr_physics_collider(JsonText& json, std::size_t fragment, std::size_t hull,
                                const SceneLayout& layout);

/// The same member of a node that does not move: one convex collider of a mesh.
void write_khr_physics_static_collider(JsonText& json, std::size_t mesh);

}  // namespace fracture
