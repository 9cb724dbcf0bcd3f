#include "common/gltf/passed_through.hpp"

#include <algorithm>
#include <set>
#include <string_view>

#include "common/gltf/names.hpp"

namespace fracture {
namespace {

template <class T>
std::vector<T> gathered(const std::vector<T>& values, const std::vector<std::uint32_t>& of) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(of.size());
  for (const std::uint32_t k : of) result.push_back(values[k]);
  return result;
}

/// The given triangles, which are sorted by material, with the wedges they use in order of first use.
Fragment mesh_of(const Mesh& mesh, const std::uint32_t* first, const std::uint32_t* last,
                 std::vector<std::uint32_t>& new_wedge) {
  Fragment result;
  std::vector<std::uint32_t> wedges;
  for (const std::uint32_t* t = first; t != last; ++t) {
    const std::uint32_t material = mesh.material[*t];
    const auto index = static_cast<std::uint32_t>(result.indices.size());
    if (result.primitives.empty() || result.primitives.back().material != material)
      result.primitives.push_back({material, index, 0});
    result.primitives.back().index_count += 3;
    for (const std::uint32_t w : mesh.triangles[*t]) {
      if (new_wedge[w] == kNoIndex) {
        new_wedge[w] = static_cast<std::uint32_t>(wedges.size());
        wedges.push_back(w);
      }
      result.indices.push_back(new_wedge[w]);
    }
  }
  for (const std::uint32_t w : wedges) new_wedge[w] = kNoIndex;
  result.positions = gathered(mesh.positions, wedges);
  result.attributes.normals = gathered(mesh.attributes.normals, wedges);
  result.attributes.tangents = gathered(mesh.attributes.tangents, wedges);
  for (const auto& set : mesh.attributes.uvs) result.attributes.uvs.push_back(gathered(set, wedges));
  for (const auto& set : mesh.attributes.colors) result.attributes.colors.push_back(gathered(set, wedges));
  return result;
}

}  // namespace

std::vector<WholeNode> whole_nodes(const FragmentSet& set, const SceneLayout& layout) {
  std::vector<WholeNode> nodes;
  if (!set.source->passed_through) return nodes;
  const Mesh& mesh = *set.source->passed_through;
  std::set<std::string> taken{"Fracture"};
  for (std::size_t k = 0; k < set.fragments.size(); ++k) {
    taken.insert(layout.name(k));
    for (std::size_t hull = 0; hull < layout.hulls(k); ++hull) {
      taken.insert(layout.hull_name(k, hull));
      taken.insert(layout.collider_name(k, hull));
    }
  }

  std::vector<std::uint32_t> order(mesh.triangles.size()), new_wedge(mesh.positions.size(), kNoIndex);
  for (std::uint32_t t = 0; t < order.size(); ++t) order[t] = t;
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mesh.node[a] != mesh.node[b] ? mesh.node[a] < mesh.node[b] : mesh.material[a] < mesh.material[b];
  });
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    const std::uint32_t node = mesh.node[order[first]];
    while (last < order.size() && mesh.node[order[last]] == node) ++last;
    const std::string_view source =
        node < mesh.node_names.size() ? std::string_view(mesh.node_names[node]) : std::string_view("mesh");
    std::string name = ascii_name(source);
    for (std::size_t number = 2; !taken.insert(name).second; ++number) {
      std::string suffix(1, '_');
      suffix += std::to_string(number);
      name = ascii_name(source, kMaxName - suffix.size()) + suffix;
    }
    nodes.push_back({std::move(name), mesh_of(mesh, order.data() + first, order.data() + last, new_wedge)});
  }
  return nodes;
}

}  // namespace fracture
