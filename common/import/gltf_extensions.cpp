#include "common/import/gltf_extensions.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "common/import/gltf_materials.hpp"
#include "common/import/gltf_variants.hpp"
#include "common/import/refused.hpp"

namespace fracture {
namespace {

using nlohmann::json;

/// Extensions that the reader applies. is_material_extension() recognizes those that materials and textures keep.
constexpr std::array<std::string_view, 8> kApplied = {"KHR_mesh_quantization",   "KHR_draco_mesh_compression",
                                                      "EXT_meshopt_compression", "KHR_meshopt_compression",
                                                      "EXT_mesh_gpu_instancing", "EXT_mesh_manifold",
                                                      "KHR_node_visibility",     "CESIUM_RTC"};

constexpr const char* kNoLights = "answers have no lights";
constexpr const char* kNoMetadata = "fragments have no feature metadata";
constexpr const char* kLooks = "fragments have the glTF core material instead";
constexpr const char* kNoAnimation = "fragments are not animated";
constexpr const char* kNoInteraction = "fragments do not react to input";
constexpr const char* kNoSound = "answers have no sound";
constexpr const char* kNoAvatar = "fragments are not an avatar";
constexpr const char* kOwnPhysics = "fragments have their own bodies and colliders";
constexpr const char* kNotApplied = "the extension is unknown, so it was not applied";

struct Harmless {
  std::string_view name;
  const char* reason;
};

/// Extensions that do not change which triangles a file shows at rest, and that the answer does not contain. Their
/// specifications are in the registries of Khronos (github.com/KhronosGroup/glTF, extensions/2.0), of VRM and of OMI.
constexpr Harmless kHarmless[] = {
    {"KHR_lights_punctual", kNoLights},
    {"EXT_lights_image_based", kNoLights},
    {"EXT_lights_ies", kNoLights},
    {"KHR_environment_map", kNoLights},
    {"KHR_materials_variants", "the file has no list of variants"},
    {"KHR_texture_procedurals", kLooks},
    {"EXT_texture_video", kLooks},
    {"EXT_texture_procedurals_mx_1_39", kLooks},
    {"KHR_techniques_webgl", kLooks},
    {"ADOBE_materials_clearcoat_specular", kLooks},
    {"ADOBE_materials_clearcoat_tint", kLooks},
    {"ADOBE_materials_thin_transparency", kLooks},
    {"MSFT_packing_normalRoughnessMetallic", kLooks},
    {"MSFT_packing_occlusionRoughnessMetallic", kLooks},
    {"NV_materials_mdl", kLooks},
    {"VRMC_materials_mtoon", kLooks},
    {"VRMC_materials_hdr_emissiveMultiplier", kLooks},
    {"KHR_xmp_json_ld", "answers carry only the copyright of the source"},
    {"KHR_xmp", "answers carry only the copyright of the source"},
    {"EXT_structural_metadata", kNoMetadata},
    {"EXT_feature_metadata", kNoMetadata},
    {"EXT_mesh_features", kNoMetadata},
    {"EXT_instance_features", kNoMetadata},
    {"FB_geometry_metadata", "its counts and bounds are those of the unbroken mesh"},
    {"CESIUM_primitive_outline", "fragments have no outlines"},
    {"KHR_animation_pointer", kNoAnimation},
    {"AGI_articulations", "nodes stay where the file places them"},
    {"AGI_stk_metadata", kNoMetadata},
    {"KHR_interactivity", kNoInteraction},
    {"KHR_node_hoverability", kNoInteraction},
    {"KHR_node_selectability", kNoInteraction},
    {"KHR_audio_emitter", kNoSound},
    {"KHR_audio", kNoSound},
    {"MSFT_audio_emitter", kNoSound},
    {"MSFT_lod", "only the scene's nodes are fractured; they are the most detailed level"},
    {"VRM", kNoAvatar},
    {"VRMC_vrm", kNoAvatar},
    {"VRMC_springBone", kNoAvatar},
    {"VRMC_node_constraint", kNoAvatar},
    {"VRMC_vrm_animation", kNoAvatar},
    {"GODOT_single_root", "the answer has its own root node"},
    {"KHR_physics_rigid_bodies", kOwnPhysics},
    {"KHR_collision_shapes", kOwnPhysics},
    {"KHR_implicit_shapes", kOwnPhysics},
    {"MSFT_physics_rigid_bodies", kOwnPhysics},
    {"MSFT_collision_primitives", kOwnPhysics},
    {"OMI_physics_body", kOwnPhysics},
    {"OMI_physics_shape", kOwnPhysics},
    {"OMI_physics_joint", kOwnPhysics},
    {"OMI_collider", kOwnPhysics},
};

bool is_applied(std::string_view name) {
  return std::find(kApplied.begin(), kApplied.end(), name) != kApplied.end();
}

const Harmless* harmless(std::string_view name) {
  const auto* const at = std::find_if(std::begin(kHarmless), std::end(kHarmless),
                                      [&](const Harmless& each) { return each.name == name; });
  return at != std::end(kHarmless) ? at : nullptr;
}

/// Collects the names of all extensions at any depth. The contents of extras are not glTF.
void collect(const json& value, std::set<std::string>& names) {
  if (value.is_object()) {
    for (const auto& [key, child] : value.items()) {
      if (key == "extras") continue;
      if (key == "extensions" && child.is_object())
        for (const auto& [name, unused] : child.items()) names.insert(name);
      collect(child, names);
    }
  } else if (value.is_array()) {
    for (const json& child : value) collect(child, names);
  }
}

}  // namespace

void check_required_extensions(const json& document) {
  const auto required = document.find("extensionsRequired");
  if (required == document.end()) return;
  if (!required->is_array())
    refuse(ErrorCode::kMalformedMesh, "\"extensionsRequired\" has to be an array.", "/extensionsRequired");
  for (std::size_t k = 0; k < required->size(); ++k) {
    const std::string pointer = "/extensionsRequired/" + std::to_string(k);
    if (!(*required)[k].is_string())
      refuse(ErrorCode::kMalformedMesh, "An extension's name has to be a string.", pointer);
    const auto name = (*required)[k].get<std::string>();
    if (!is_applied(name) && !is_material_extension(name) && harmless(name) == nullptr)
      refuse(ErrorCode::kUnsupportedFeature,
             "The file requires the extension " + name.substr(0, 80) + ", which is not supported.", pointer,
             {{"extension", name.substr(0, 80)}});
  }
}

std::vector<Dropped> dropped_extensions(const json& document) {
  std::set<std::string> names;
  collect(document, names);
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    if (const auto at = document.find(list); at != document.end() && at->is_array())
      for (const json& name : *at)
        if (name.is_string()) names.insert(name.get<std::string>());
  std::vector<Dropped> dropped;
  for (const std::string& name : names) {
    if (is_applied(name) || is_material_extension(name)) continue;
    if (name == "KHR_materials_variants" && has_variants(document)) continue;  // see read_variants()
    const Harmless* const known = harmless(name);
    dropped.push_back({"extension", name, known != nullptr ? known->reason : kNotApplied});
  }
  return dropped;
}

MeshoptView meshopt_view(const json& view) {
  const auto extensions = view.find("extensions");
  if (extensions == view.end() || !extensions->is_object()) return {};
  for (const char* name : {"KHR_meshopt_compression", "EXT_meshopt_compression"})
    if (const auto it = extensions->find(name); it != extensions->end() && it->is_object())
      return {name, &*it};
  return {};
}

}  // namespace fracture
