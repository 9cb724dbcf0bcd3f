#include "common/gltf/passed_through.hpp"

#include <algorithm>
#include <string_view>

#include "common/base/gathered.hpp"
#include "common/base/pacer.hpp"
#include "common/gltf/unique_names.hpp"

namespace fracture {
namespace {

/// Returns a mesh of the given triangles, which are sorted by material. Its wedges are in order of first use.
Fragment mesh_of(const Mesh& mesh, const std::uint32_t* first, const std::uint32_t* last,
                 std::vector<std::uint32_t>& new_wedge, Pacer& pacer) {
  Fragment result;
  std::vector<std::uint32_t> wedges;
  for (const std::uint32_t* t = first; t != last; ++t) {
    pacer.step(2);
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
  const auto of_wedges = [&](const auto& values) { return gathered(values, wedges, [&] { pacer.step(); }); };
  result.positions = of_wedges(mesh.positions);
  result.attributes.normals = of_wedges(mesh.attributes.normals);
  result.attributes.tangents = of_wedges(mesh.attributes.tangents);
  for (const auto& set : mesh.attributes.uvs) result.attributes.uvs.push_back(of_wedges(set));
  for (const auto& set : mesh.attributes.colors) result.attributes.colors.push_back(of_wedges(set));
  return result;
}

}  // namespace

std::vector<WholeNode> whole_nodes(const FragmentSet& set, const SceneLayout& layout,
                                   const Execution& execution) {
  std::vector<WholeNode> nodes;
  if (!set.source->passed_through) return nodes;
  Pacer pacer(execution);
  const Mesh& mesh = *set.source->passed_through;
  UniqueNames names(layout, set.fragments.size(), execution);
  std::vector<std::uint32_t> order(mesh.triangles.size()), new_wedge(mesh.positions.size(), kNoIndex);
  for (std::uint32_t t = 0; t < order.size(); ++t) order[t] = t;
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (mesh.node[a] != mesh.node[b]) return mesh.node[a] < mesh.node[b];
    return mesh.material[a] != mesh.material[b] ? mesh.material[a] < mesh.material[b] : a < b;
  });
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    const std::uint32_t node = mesh.node[order[first]];
    while (last < order.size() && mesh.node[order[last]] == node) ++last;
    pacer.step(16);
    std::string name = names.add(node < mesh.node_names.size() ? std::string_view(mesh.node_names[node])
                                                               : std::string_view("mesh"));
    nodes.push_back(
        {node, std::move(name), mesh_of(mesh, order.data() + first, order.data() + last, new_wedge, pacer)});
  }
  return nodes;
}

}  // namespace fracture
