#include "common/gltf/scene_layout.hpp"

#include <algorithm>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/gltf/names.hpp"

namespace fracture {

void write_offset(JsonText& json, const Mesh& source) {
  if (!(source.frame.offset == Vec3d{})) json.member("translation", source.frame.offset);
}

const InstancedBodies::Body* instance_in_file(const FracturedSolid& fractured, const GltfOptions& options,
                                              std::size_t fragment) {
  const InstancedBodies::Body* const body = fractured.instances.of(fragment);
  return body != nullptr && (options.physics != Physics::kOmi || body->scale == 1) ? body : nullptr;
}

SceneLayout::SceneLayout(const FracturedSolid& fractured, const GltfOptions& options,
                         const Execution& execution)
    : physics_(options.physics != Physics::kNone), ucx_(options.ue_collision == UeCollision::kUcx) {
  Pacer pacer(execution);
  const FragmentSet& set = fractured.set;
  const std::size_t count = set.fragments.size();
  number_meshes(fractured, options);
  const std::size_t most =
      hull_count_.empty() ? 0 : *std::max_element(hull_count_.begin(), hull_count_.end());
  digits_ = std::max<std::size_t>(2, std::to_string(std::max<std::size_t>(most, 1) - 1).size());

  // Leaves room for the longest suffix of a hull, collider or sheet, so that their names have at most kMaxName bytes,
  // too.
  const std::size_t room = has_hulls() ? kMaxName - digits_ - std::string_view("__collider").size()
                           : !first_sheet_.empty() ? kMaxName - std::string_view("_sheet").size()
                                                   : kMaxName;
  names_.reserve(count);
  const std::vector<std::string> sources =
      names_of_sources(set.source->node_names, room - fragment_suffix(count), execution);
  for (std::size_t k = 0; k < count; ++k) {
    pacer.step(4);
    const std::uint32_t node = set.fragments[k].node;
    names_.push_back(
        fragment_name(node < sources.size() ? std::string_view(sources[node]) : "mesh", k, count));
  }

  if (options.physics == Physics::kKhr && has_hulls() && fractured.rest) filters_ = &fractured.rest->filters;

  std::size_t node = 1 + count;
  first_child_.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    first_child_.push_back(node);
    node += children(k);
  }
}

void SceneLayout::number_meshes(const FracturedSolid& fractured, const GltfOptions& options) {
  const InstancedBodies& instances = fractured.instances;
  const std::size_t count = fractured.set.fragments.size();
  std::vector<std::size_t> number(instances.shapes.size(), kNoIndex);  // per shape: index into shapes_
  if (!instances.of_fragment.empty()) {
    instance_.assign(count, nullptr);
    for (std::size_t k = 0; k < count; ++k) {
      const InstancedBodies::Body* const body = instance_in_file(fractured, options, k);
      if (body == nullptr) continue;
      instance_[k] = body;
      if (number[body->shape] != kNoIndex) continue;
      number[body->shape] = shapes_.size();
      shapes_.push_back({body->shape, k});
    }
  }
  std::size_t next = 0;
  mesh_.resize(count);
  for (std::size_t k = 0; k < count; ++k)
    if (instance(k) == nullptr) mesh_[k] = next++;
  for (std::size_t k = 0; k < count; ++k)
    if (instance(k) != nullptr) mesh_[k] = next + number[instance(k)->shape];
  next += shapes_.size();
  first_hull_mesh_ = next;
  first_hull_.resize(count);
  hull_count_.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    hull_count_[k] = physics_ || ucx_ ? fractured.hulls.of(k).size() : 0;
    if (instance(k) != nullptr) continue;
    first_hull_[k] = next;
    next += hull_count_[k];
  }
  std::vector<std::size_t> first_of_shape;
  for (const Shape& shape : shapes_) {
    first_of_shape.push_back(next);
    next += hull_count_[shape.fragment];
  }
  for (std::size_t k = 0; k < count; ++k)
    if (instance(k) != nullptr) first_hull_[k] = first_of_shape[number[instance(k)->shape]];
  hull_mesh_count_ = next - first_hull_mesh_;

  const std::vector<Fragment>& fragments = fractured.set.fragments;
  const auto carries = [](const Fragment& f) { return f.sheet != nullptr; };
  if (std::any_of(fragments.begin(), fragments.end(), carries)) {
    first_sheet_.reserve(count + 1);
    for (const Fragment& f : fragments) {
      first_sheet_.push_back(next);
      next += carries(f) ? 1 : 0;
    }
    first_sheet_.push_back(next);
  }
  mesh_count_ = next;
}

std::string SceneLayout::hull_name(std::size_t fragment, std::size_t hull) const {
  std::string name;
  name.reserve(names_[fragment].size() + 24);
  if (ucx_) name = "UCX_";
  name += names_[fragment];
  name += '_';
  name += padded(hull, digits_);
  if (!ucx_) name += "_hull";
  return name;
}

std::string SceneLayout::collider_name(std::size_t fragment, std::size_t hull) const {
  return names_[fragment] + "_" + padded(hull, digits_) + "_collider";
}

}  // namespace fracture
