#include "common/import/gltf_dropped.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "common/import/gltf_extensions.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/source_tree.hpp"

namespace fracture {
namespace {

using nlohmann::json;

const json kNothing = json::array();

/// Extensions that make a node a body, a collider or a joint.
constexpr const char* kPhysics[] = {"KHR_physics_rigid_bodies", "OMI_physics_body", "OMI_physics_joint",
                                    "OMI_collider", "MSFT_physics_rigid_bodies"};

/// Returns the array `object[key]`, or an empty one.
const json& list_in(const json& object, const char* key) {
  if (!object.is_object()) return kNothing;
  const auto it = object.find(key);
  return it != object.end() && it->is_array() ? *it : kNothing;
}

/// Returns the object `extensions[name]`, or an empty array.
const json& extension_in(const json& object, const char* name) {
  if (!object.is_object()) return kNothing;
  const auto extensions = object.find("extensions");
  if (extensions == object.end() || !extensions->is_object()) return kNothing;
  const auto it = extensions->find(name);
  return it != extensions->end() && it->is_object() ? *it : kNothing;
}

std::string name_or(const json& object, std::string otherwise) {
  if (!object.is_object()) return otherwise;
  const auto it = object.find("name");
  const bool named = it != object.end() && it->is_string() && !it->get_ref<const std::string&>().empty();
  return named ? it->get<std::string>() : otherwise;
}

std::string pointer_to(const std::string& list, std::size_t index) {
  return "/" + list + "/" + std::to_string(index);
}

/// Returns `object[key]` if it is an index.
std::optional<std::uint64_t> index_in(const json& object, const char* key) {
  if (!object.is_object()) return std::nullopt;
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number_unsigned()) return std::nullopt;
  return it->get<std::uint64_t>();
}

/// Lists the entries of an array that a node may refer to. An entry without a name gets that of its first node.
template <class IndexOf>
void add_held_by_nodes(const json& document, const json& entries, const std::string& pointer,
                       const char* what, const char* reason, IndexOf&& index_of,
                       std::vector<Dropped>& dropped) {
  std::map<std::uint64_t, std::string> holder;
  for (const json& node : list_in(document, "nodes"))
    if (const auto index = index_of(node); index && !name_or(node, "").empty())
      holder.emplace(*index, name_or(node, ""));
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const auto held = holder.find(k);
    dropped.push_back(
        {what, name_or(entries[k], held != holder.end() ? held->second : pointer_to(pointer, k)), reason});
  }
}

void add_all(const json& entries, const std::string& pointer, const char* what, const char* reason,
             std::vector<Dropped>& dropped) {
  for (std::size_t k = 0; k < entries.size(); ++k)
    dropped.push_back({what, name_or(entries[k], pointer_to(pointer, k)), reason});
}

bool has_extras(const json& object) {
  return object.is_object() && object.contains("extras") && !object["extras"].is_null();
}

void add_extras(const json& object, const std::string& name, std::vector<Dropped>& dropped) {
  if (has_extras(object))
    dropped.push_back({"extras", name, "only the extras of nodes, materials and textures are kept"});
}

/// Returns the attributes that fragments keep or the importer applies. Sets are read up to the first missing one.
std::set<std::string> names_read(const json& attributes) {
  std::set<std::string> names{"POSITION", "NORMAL", "TANGENT"};
  for (const char* kind : {"TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"})
    for (std::size_t k = 0; attributes.contains(kind + std::to_string(k)); ++k)
      names.insert(kind + std::to_string(k));
  return names;
}

/// Whether fragments need the primitive's tangents, because its material or that of a variant has a normal map. `normal_mapped`: per
/// material.
bool needs_tangents(const std::vector<bool>& normal_mapped, const json& primitive) {
  const auto is_mapped = [&](const json& holder) {
    const auto index = index_in(holder, "material");
    return index && *index < normal_mapped.size() && normal_mapped[*index];
  };
  const json& mappings = list_in(extension_in(primitive, "KHR_materials_variants"), "mappings");
  return is_mapped(primitive) || std::any_of(mappings.begin(), mappings.end(), is_mapped);
}

void add_primitive(const std::vector<bool>& normal_mapped, const json& primitive, const std::string& mesh,
                   std::vector<Dropped>& dropped) {
  add_extras(primitive, "a primitive of " + mesh, dropped);
  const std::uint64_t mode = index_in(primitive, "mode").value_or(4);
  if (mode < 4) dropped.push_back({mode == 0 ? "points" : "lines", mesh, "only triangles are fractured"});
  if (mode > 6) dropped.push_back({"primitive", mesh, "glTF 2.0 does not define its mode"});
  const auto attributes = primitive.is_object() ? primitive.find("attributes") : primitive.end();
  if (mode < 4 || mode > 6 || attributes == primitive.end() || !attributes->is_object()) return;
  if (!attributes->contains("POSITION")) {
    dropped.push_back({"primitive", mesh, "it has no positions"});
    return;
  }
  const std::set<std::string> read = names_read(*attributes);
  for (const auto& [name, unused] : attributes->items())
    if (!read.contains(name))
      dropped.push_back({"attribute", name + " of " + mesh,
                         "fragments have only positions, normals, tangents, UVs and colours"});
  if (attributes->contains("TANGENT") && !needs_tangents(normal_mapped, primitive))
    dropped.push_back({"attribute", "TANGENT of " + mesh,
                       "only surfaces with a normal map need tangents, and this one has none"});
  if (!list_in(primitive, "targets").empty())
    dropped.push_back(
        {"morph targets", mesh, "they are applied at their default weights; fragments do not morph"});
}

/// Attributes of instances (EXT_mesh_gpu_instancing) other than their transforms.
void add_instances(const json& node, const std::string& name, std::vector<Dropped>& dropped) {
  const json& extension = extension_in(node, "EXT_mesh_gpu_instancing");
  const auto attributes = extension.is_object() ? extension.find("attributes") : extension.end();
  if (attributes == extension.end() || !attributes->is_object()) return;
  for (const auto& [attribute, unused] : attributes->items())
    if (attribute != "TRANSLATION" && attribute != "ROTATION" && attribute != "SCALE")
      dropped.push_back({"attribute", attribute + " of " + name, "instances have only transforms"});
}

void add_scenes(const json& document, std::vector<Dropped>& dropped) {
  const json& scenes = list_in(document, "scenes");
  const std::uint64_t shown = index_in(document, "scene").value_or(0);
  for (std::size_t k = 0; k < scenes.size(); ++k)
    if (k != shown)
      dropped.push_back(
          {"scene", name_or(scenes[k], pointer_to("scenes", k)), "only the default scene is fractured"});
}

/// The members of a node's extras that are the results of an earlier fracture.
bool is_result(const std::string& member) {
  return member == "fracture" || member == "intact" || member == "whole";
}

/// Returns whether a glTF node can have the transform: translation, rotation and scale. Tolerance: rounding to floats.
bool is_node_transform(const Transform& m) {
  const double x = length(m.x), y = length(m.y), z = length(m.z);
  const auto fits = [](double value) { return std::abs(value) <= std::numeric_limits<float>::max(); };
  constexpr double kRounding = 1e-6;
  return x > 0 && y > 0 && z > 0 && fits(x) && fits(y) && fits(z) && fits(m.t.x) && fits(m.t.y) &&
         fits(m.t.z) && std::abs(dot(m.x, m.y)) <= kRounding * x * y &&
         std::abs(dot(m.y, m.z)) <= kRounding * y * z && std::abs(dot(m.z, m.x)) <= kRounding * z * x;
}

/// Returns whether the node is a part of the source's physics, such as the collider of a compound.
bool is_physical(const json& node) {
  const auto extensions = node.find("extensions");
  if (extensions == node.end() || !extensions->is_object()) return false;
  return std::any_of(std::begin(kPhysics), std::end(kPhysics),
                     [&](const char* name) { return extensions->contains(name); });
}

/// Keeps the node, or returns why that is not done.
const char* keep_empty(const json& node, const Transform& world, std::vector<EmptyNode>& kept) {
  if (is_physical(node)) return "fragments have their own bodies and colliders";
  if (!is_node_transform(world)) return "its transform is sheared, flat or too large for a single node";
  if (kept.size() >= kMostEmptyNodes) return "an answer has at most 1,000 nodes without a mesh";
  kept.push_back({name_or(node, "empty"), world.x, world.y, world.z, world.t, carried_extras(node)});
  return nullptr;
}

}  // namespace

std::vector<Dropped> dropped_from(const json& document) {
  std::vector<Dropped> dropped = dropped_extensions(document);
  add_held_by_nodes(
      document, list_in(extension_in(document, "KHR_lights_punctual"), "lights"),
      "extensions/KHR_lights_punctual/lights", "light", "answers have no lights",
      [](const json& node) { return index_in(extension_in(node, "KHR_lights_punctual"), "light"); }, dropped);
  add_held_by_nodes(
      document, list_in(document, "cameras"), "cameras", "camera", "answers have no cameras",
      [](const json& node) { return index_in(node, "camera"); }, dropped);
  add_all(list_in(document, "animations"), "animations", "animation", "fragments are not animated", dropped);
  add_all(list_in(document, "skins"), "skins", "skin", "its pose is applied; fragments have no bones",
          dropped);
  add_scenes(document, dropped);
  std::vector<bool> normal_mapped;
  for (const json& material : list_in(document, "materials"))
    normal_mapped.push_back(has_normal_map(material, [] {}));
  const json& meshes = list_in(document, "meshes");
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const std::string mesh = name_or(meshes[k], pointer_to("meshes", k));
    add_extras(meshes[k], mesh, dropped);
    for (const json& primitive : list_in(meshes[k], "primitives"))
      add_primitive(normal_mapped, primitive, mesh, dropped);
  }
  add_extras(document, "/extras", dropped);
  if (const auto asset = document.find("asset"); asset != document.end())
    add_extras(*asset, "/asset/extras", dropped);
  for (const char* list : {"scenes", "skins", "accessors", "bufferViews", "buffers", "images"}) {
    const json& entries = list_in(document, list);
    for (std::size_t k = 0; k < entries.size(); ++k)
      add_extras(entries[k], name_or(entries[k], pointer_to(list, k)), dropped);
  }
  return dropped;
}

std::string carried_extras(const json& node) {
  if (!has_extras(node) || !node["extras"].is_object()) return {};
  std::string members;
  for (const auto& [key, value] : node["extras"].items()) {
    if (is_result(key)) continue;
    if (!members.empty()) members += ',';
    members += json(key).dump() + ':' + value.dump();
    if (members.size() > kMostNodeExtras) return {};
  }
  return members;
}

OtherNodes other_nodes(const json& document, const tinygltf::Model& model, const GltfScene& scene) {
  enum : std::uint8_t { kElsewhere, kShown, kHidden };
  const std::size_t count = model.nodes.size();
  std::vector<std::uint8_t> state(count, kElsewhere);
  for (const int index : scene.order) state[static_cast<std::size_t>(index)] = kShown;
  for (const int index : scene.hidden) state[static_cast<std::size_t>(index)] = kHidden;
  std::vector<bool> is_joint(count), mesh_below(count), mesh_shown(model.meshes.size());
  std::vector<std::uint32_t> level(count, 0);  // number of nodes above it that are in the tree of the source
  for (const tinygltf::Skin& skin : model.skins)
    for (const int joint : skin.joints)
      if (joint >= 0 && static_cast<std::size_t>(joint) < count)
        is_joint[static_cast<std::size_t>(joint)] = true;
  for (auto it = scene.order.rbegin(); it != scene.order.rend();
       ++it) {  // children come before their parents
    const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(*it)];
    for (const int child : node.children) {
      const auto at = static_cast<std::size_t>(child);
      if (state[at] == kShown && (mesh_below[at] || model.nodes[at].mesh >= 0))
        mesh_below[static_cast<std::size_t>(*it)] = true;
    }
    if (node.mesh >= 0 && static_cast<std::size_t>(node.mesh) < mesh_shown.size())
      mesh_shown[static_cast<std::size_t>(node.mesh)] = true;
  }

  for (const int index : scene.order) {
    const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(index)];
    const std::uint32_t own = node.mesh >= 0 || !node.name.empty() ? 1 : 0;
    for (const int child : node.children)
      level[static_cast<std::size_t>(child)] =
          std::min(level[static_cast<std::size_t>(index)] + own, kMostSourceLevels);
  }

  OtherNodes result;
  std::vector<Dropped>& dropped = result.dropped;
  const json& nodes = list_in(document, "nodes");
  for (std::size_t n = 0; n < std::min(count, nodes.size()); ++n) {
    const json& node = nodes[n];
    const std::string name = name_or(node, pointer_to("nodes", n));
    const bool has_mesh = model.nodes[n].mesh >= 0;
    bool in_answer = has_mesh && state[n] == kShown;
    const auto drop = [&](const char* reason) { dropped.push_back({"node", name, reason}); };
    if (state[n] == kElsewhere)
      drop("it is not in the default scene");
    else if (state[n] == kHidden)
      drop("KHR_node_visibility hides it");
    else if (!has_mesh && mesh_below[n] && model.nodes[n].name.empty())
      drop("its transform is applied; groups of fragments need a name, and it has none");
    else if (!has_mesh && mesh_below[n] && level[n] >= kMostSourceLevels)
      drop("its transform is applied, but answers have at most 64 levels of groups");
    else if (!has_mesh && mesh_below[n])
      in_answer = true;  // a group (SourceTree)
    else if (!has_mesh && is_joint[n])
      dropped.push_back({"bone", name, "its pose is applied; fragments have no bones"});
    else if (!has_mesh) {
      const char* const reason = keep_empty(node, *scene.world[n], result.kept);
      in_answer = reason == nullptr;
      if (reason != nullptr) drop(reason);
    }
    if (has_extras(node) && !(in_answer && !carried_extras(node).empty())) {
      const json& extras = node["extras"];
      const bool only_results =
          extras.is_object() && std::all_of(extras.items().begin(), extras.items().end(),
                                            [](const auto& member) { return is_result(member.key()); });
      if (!only_results)
        dropped.push_back({"extras", name,
                           !in_answer           ? "their node is not in the answer"
                           : extras.is_object() ? "they are too long to be copied to each fragment"
                                                : "only a JSON object can be added to a fragment's extras"});
    }
    add_instances(node, name, dropped);
  }
  const json& meshes = list_in(document, "meshes");
  for (std::size_t m = 0; m < std::min(meshes.size(), mesh_shown.size()); ++m)
    if (!mesh_shown[m])
      dropped.push_back(
          {"mesh", name_or(meshes[m], pointer_to("meshes", m)), "no visible node of the scene uses it"});
  return result;
}

}  // namespace fracture
