#include "common/gltf/scene_layout.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/gltf/names.hpp"

namespace fracture {

void write_offset(JsonText& json, const Mesh& source) {
  if (!(source.frame.offset == Vec3d{})) json.member("translation", source.frame.offset);
}

SceneLayout::SceneLayout(const FracturedSolid& fractured, const GltfOptions& options,
                         const Execution& execution)
    : physics_(options.physics != Physics::kNone), ucx_(options.ue_collision == UeCollision::kUcx) {
  Pacer pacer(execution);
  const FragmentSet& set = fractured.set;
  const std::size_t count = set.fragments.size();
  std::size_t mesh = count, most = 0;
  first_hull_.reserve(count + 1);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t here = fractured.hulls.of(k).size();
    first_hull_.push_back(mesh);
    if (physics_ || ucx_) mesh += here;
    most = std::max(most, here);
  }
  first_hull_.push_back(mesh);
  digits_ = std::max<std::size_t>(2, std::to_string(std::max<std::size_t>(most, 1) - 1).size());

  const auto carries = [&](const Fragment& f) { return f.sheet != nullptr; };
  if (std::any_of(set.fragments.begin(), set.fragments.end(), carries)) {
    first_sheet_.reserve(count + 1);
    for (const Fragment& f : set.fragments) {
      first_sheet_.push_back(mesh);
      mesh += carries(f) ? 1 : 0;
    }
    first_sheet_.push_back(mesh);
  }

  // Leaves room for the longest suffix of a hull, collider or sheet, so that their names have at most kMaxName bytes,
  // too.
  const std::size_t room = has_hulls() ? kMaxName - digits_ - std::string_view("__collider").size()
                           : !first_sheet_.empty() ? kMaxName - std::string_view("_sheet").size()
                                                   : kMaxName;
  names_.reserve(count);
  const auto& sources = set.source->node_names;
  for (std::size_t k = 0; k < count; ++k) {
    pacer.step(4);
    const std::uint32_t node = set.fragments[k].node;
    const std::string_view source = node < sources.size() ? std::string_view(sources[node]) : "mesh";
    // Unreal would take a fragment whose name begins with UCX_ for collision geometry.
    std::string base(ucx_ && source.starts_with("UCX_") ? 1 : 0, '_');
    base += source;
    names_.push_back(fragment_name(base, k, count, room));
  }

  if (options.physics == Physics::kKhr && has_hulls() && fractured.rest) filters_ = &fractured.rest->filters;

  std::size_t node = 1 + count;
  first_child_.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    first_child_.push_back(node);
    node += children(k);
  }
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
