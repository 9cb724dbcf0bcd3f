// OMI_physics_body and OMI_physics_shape (Open Metaverse Interoperability Group): what Godot imports.
#pragma once

#include "common/fragment/fragments.hpp"
#include "common/gltf/intact_scene.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

/// The document's member "OMI_physics_shape": one convex shape for each hull mesh of the fragments, in the same order, then
/// one for each of the intact solid. Nothing without hulls.
void write_omi_physics_document(JsonText& json, const FragmentSet& set, const SceneLayout& layout,
                                const IntactScene& intact);

/// The node's member "OMI_physics_body" of a fragment: dynamic motion with mass and centre (no inertia: Godot
/// computes its own), and the collider where it is one hull.
void write_omi_physics_body(JsonText& json, const Fragment& fragment, std::size_t index,
                            const SceneLayout& layout, const GltfOptions& options);

/// The same member of a compound's child node.
void write_omi_physics_collider(JsonText& json, std::size_t shape);

}  // namespace fracture
