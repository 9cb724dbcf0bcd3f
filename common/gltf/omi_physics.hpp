// OMI_physics_body and OMI_physics_shape (Open Metaverse Interoperability Group): the extensions that Godot imports.
#pragma once

#include "common/fragment/fragments.hpp"
#include "common/gltf/intact_scene.hpp"
#include "common/gltf/json_text.hpp"
#include "common/gltf/scene_layout.hpp"

namespace fracture {

/// Writes the document's member "OMI_physics_shape". It lists one convex shape for each hull mesh: first those of the
/// fragments, then those of the intact solid. If there are no hulls, nothing is written.
void write_omi_physics_document(JsonText& json, const SceneLayout& layout, const IntactScene& intact);

/// Writes the member "OMI_physics_body" of a fragment's node: dynamic motion with mass and centre, without inertia
/// (Godot computes it), and the collider if the fragment has a single hull.
void write_omi_physics_body(JsonText& json, const Fragment& fragment, std::size_t index,
                            const SceneLayout& layout, const GltfOptions& options);

/// Writes the same member for a compound's child node.
void write_omi_physics_collider(JsonText& json, std::size_t shape);

}  // namespace fracture
