#include "common/gltf/intact_scene.hpp"

#include <algorithm>
#include <string_view>

#include "common/base/pacer.hpp"
#include "common/gltf/khr_physics.hpp"
#include "common/gltf/names.hpp"
#include "common/gltf/omi_physics.hpp"
#include "common/physics/principal_axes.hpp"

namespace fracture {

IntactScene::IntactScene(const FracturedSolid& fractured, const GltfOptions& options,
                         const SceneLayout& layout, const std::vector<WholeNode>& whole,
                         const Execution& execution)
    : fractured_(fractured),
      execution_(execution),
      has_physics_(options.physics != Physics::kNone),
      ucx_(options.ue_collision == UeCollision::kUcx) {
  if (!fractured.intact || fractured.intact->parts.empty()) return;
  const std::vector<Fragment>& parts = fractured.intact->parts;
  constexpr std::string_view kSuffix = "_intact";
  // Leaves room for the longest suffix of a hull or collider, so that their names have at most kMaxName bytes, too.
  std::size_t most = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) most = std::max(most, fractured.intact->hulls.of(k).size());
  digits_ = std::max<std::size_t>(2, std::to_string(std::max<std::size_t>(most, 1) - 1).size());
  const std::size_t room = kMaxName - digits_ - std::string_view("__collider").size();
  UniqueNames names(layout, fractured.set.fragments.size(), execution);
  for (const WholeNode& node : whole) names.take(node.name);
  for (const EmptyNode& node : fractured.set.source->empty_nodes) names.take(kept_name(node.name));
  root_name_ = names.add("Intact");
  const auto& sources = fractured.set.source->node_names;
  first_hull_.push_back(0);
  node_count_ = 1 + parts.size() + whole.size();
  Pacer pacer(execution);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    pacer.step(32);
    const std::string_view source =
        parts[k].node < sources.size() ? std::string_view(sources[parts[k].node]) : "mesh";
    names_.push_back(names.add(visible_name(source), kSuffix, room));
    first_hull_.push_back(first_hull_.back() +
                          (has_physics_ || ucx_ ? fractured.intact->hulls.of(k).size() : 0));
    node_count_ += children(k);
  }
  for (const WholeNode& node : whole) {
    whole_names_.push_back(names.add(node.name, kSuffix));
    whole_extras_.push_back(node.extras);
  }
  first_node_ = layout.node_count() + whole.size();
  first_whole_mesh_ = layout.mesh_count();
  first_mesh_ = first_whole_mesh_ + whole.size();
  first_shape_ = layout.hull_count();
}

void IntactScene::take_names(UniqueNames& names) const {
  if (is_empty()) return;
  names.take(root_name_);
  for (std::size_t k = 0; k < names_.size(); ++k) {
    names.take(names_[k]);
    for (std::size_t hull = 0; hull < hulls(k); ++hull) {
      names.take(hull_name(k, hull));
      names.take(collider_name(k, hull));
    }
    if (has_sheet(k)) names.take(names_[k] + "_sheet");
  }
  for (const std::string& name : whole_names_) names.take(name);
}

std::string IntactScene::collider_name(std::size_t part, std::size_t hull) const {
  return names_[part] + "_" + padded(hull, digits_) + "_collider";
}

std::string IntactScene::hull_name(std::size_t part, std::size_t hull) const {
  const std::string name = names_[part] + "_" + padded(hull, digits_);
  return ucx_ ? "UCX_" + name : name + "_hull";
}

void IntactScene::write_collider(JsonText& json, std::size_t part, std::size_t hull,
                                 const GltfOptions& options) const {
  json.key("extensions").begin_object();
  if (options.physics == Physics::kKhr)
    write_khr_physics_static_collider(json, fractured_.intact->parts[part], first_hull_mesh() + hull,
                                      options);
  else
    write_omi_physics_collider(json, first_shape_ + hull);
  json.end_object();
}

void IntactScene::write_part(JsonText& json, std::size_t part, std::size_t first_child,
                             const GltfOptions& options) const {
  json.begin_object().member("name", names_[part]).member("mesh", first_mesh_ + part);
  if (children(part) > 0) {
    json.key("children").begin_array();
    for (std::size_t k = 0; k < children(part); ++k) json.value(first_child + k);
    json.end_array();
  }
  if (has_physics_ && hulls(part) == 1) write_collider(json, part, first_hull_[part], options);
  const Fragment& f = fractured_.intact->parts[part];
  json.key("extras").begin_object().key("intact").begin_object();
  json.member("part", f.source_part).member("volume", body_volume(f));
  json.member("mass", body_volume(f) * options.density * f.density_share)
      .end_object()
      .end_object()
      .end_object();
}

void IntactScene::write_nodes(JsonText& json, const GltfOptions& options) const {
  if (is_empty()) return;
  const std::size_t first_part = first_node_ + 1, first_child = first_part + names_.size();
  std::size_t children_before = 0;
  for (std::size_t k = 0; k < names_.size(); ++k) children_before += children(k);
  json.begin_object().member("name", root_name_);
  write_offset(json, *fractured_.set.source);
  json.key("children").begin_array();
  for (std::size_t k = 0; k < names_.size(); ++k) json.value(first_part + k);
  for (std::size_t k = 0; k < whole_names_.size(); ++k) json.value(first_child + children_before + k);
  json.end_array().key("extras").begin_object().key("intact").begin_object();
  if (!options.mesh_digest.empty()) json.member("mesh", options.mesh_digest);
  json.member("parts", names_.size()).end_object().end_object().end_object();

  std::size_t child = first_child, sheet_mesh = first_hull_mesh() + hull_count();
  for (std::size_t k = 0; k < names_.size(); ++k) {
    write_part(json, k, child, options);
    child += children(k);
  }
  for (std::size_t k = 0; k < names_.size(); ++k) {
    for (std::size_t hull = 0; hull < colliders(k); ++hull) {
      json.begin_object().member("name", collider_name(k, hull));
      write_collider(json, k, first_hull_[k] + hull, options);
      json.end_object();
    }
    for (std::size_t hull = 0; ucx_ && hull < hulls(k); ++hull)
      json.begin_object()
          .member("name", hull_name(k, hull))
          .member("mesh", first_hull_mesh() + first_hull_[k] + hull)
          .end_object();
    if (has_sheet(k))
      json.begin_object().member("name", names_[k] + "_sheet").member("mesh", sheet_mesh++).end_object();
  }
  for (std::size_t k = 0; k < whole_names_.size(); ++k)
    write_whole_node(json, whole_names_[k], first_whole_mesh_ + k, whole_extras_[k]);
}

void IntactScene::write_meshes(JsonText& json, const GltfOptions& options, MeshWriter& writer) const {
  if (is_empty()) return;
  const IntactSolid& intact = *fractured_.intact;
  const std::vector<MeshFigures> figures = measure(intact.parts, options.mesh_manifold, execution_);
  for (std::size_t k = 0; k < names_.size(); ++k) writer.write(json, intact.parts[k], figures[k], names_[k]);
  for (std::size_t k = 0; k < names_.size(); ++k)
    for (std::size_t hull = 0; hull < hulls(k); ++hull)
      writer.write(json, intact.hulls.of(k)[hull], hull_name(k, hull));
  Pacer pacer(execution_);
  for (std::size_t k = 0; k < names_.size(); ++k)
    if (has_sheet(k)) {
      const Fragment& sheet = *intact.parts[k].sheet;
      writer.write(json, sheet, measure(sheet, false, pacer), names_[k] + "_sheet");
    }
}

}  // namespace fracture
