#include "common/gltf/passed_through.hpp"

#include <algorithm>
#include <string_view>

#include "common/base/gathered.hpp"
#include "common/base/pacer.hpp"
#include "common/gltf/unique_names.hpp"
#include "common/solid/solid.hpp"

namespace fracture {
namespace {

/// The value of a triangle in an array that may be shorter.
std::uint32_t value_of(const std::vector<std::uint32_t>& values, std::uint32_t triangle,
                       std::uint32_t otherwise) {
  return triangle < values.size() ? values[triangle] : otherwise;
}

/// Returns a mesh of the given triangles, which are sorted by material. Its wedges are in order of first use.
Fragment mesh_of(const Mesh& mesh, const std::uint32_t* first, const std::uint32_t* last,
                 std::vector<std::uint32_t>& new_wedge, Pacer& pacer) {
  Fragment result;
  std::vector<std::uint32_t> wedges;
  for (const std::uint32_t* t = first; t != last; ++t) {
    pacer.step(2);
    const std::uint32_t material = value_of(mesh.material, *t, kNoIndex);
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

/// Appends a node for each node of the mesh that has some of these triangles.
void add_nodes(const Mesh& mesh, std::vector<std::uint32_t> order, UniqueNames& names,
               std::vector<WholeNode>& nodes, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::uint32_t> new_wedge(mesh.positions.size(), kNoIndex);
  const auto node_of = [&](std::uint32_t t) { return value_of(mesh.node, t, 0); };
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (node_of(a) != node_of(b)) return node_of(a) < node_of(b);
    const std::uint32_t x = value_of(mesh.material, a, kNoIndex), y = value_of(mesh.material, b, kNoIndex);
    return x != y ? x < y : a < b;
  });
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    const std::uint32_t node = node_of(order[first]);
    while (last < order.size() && node_of(order[last]) == node) ++last;
    pacer.step(16);
    std::string name = names.add(node < mesh.node_names.size() ? std::string_view(mesh.node_names[node])
                                                               : std::string_view("mesh"));
    nodes.push_back({node, std::move(name),
                     node < mesh.node_extras.size() ? mesh.node_extras[node] : std::string(),
                     mesh_of(mesh, order.data() + first, order.data() + last, new_wedge, pacer)});
  }
}

}  // namespace

void write_whole_node(JsonText& json, const std::string& name, std::size_t mesh, const std::string& extras) {
  json.begin_object().member("name", name).member("mesh", mesh);
  if (!extras.empty()) json.key("extras").begin_object().value_text(extras).end_object();
  json.end_object();
}

std::vector<WholeNode> whole_nodes(const FragmentSet& set, const SceneLayout& layout,
                                   const Execution& execution) {
  std::vector<WholeNode> nodes;
  // An answer without fragments has no meshes (gltf_writer.cpp).
  if (set.fragments.empty() || (!set.source->passed_through && !set.whole_sheets)) return nodes;
  UniqueNames names(layout, set.fragments.size(), execution);
  if (set.source->passed_through) {
    std::vector<std::uint32_t> all(set.source->passed_through->triangles.size());
    for (std::uint32_t t = 0; t < all.size(); ++t) all[t] = t;
    add_nodes(*set.source->passed_through, std::move(all), names, nodes, execution);
  }
  if (set.whole_sheets)
    add_nodes(*set.whole_sheets->surface->source, set.whole_sheets->triangles, names, nodes, execution);
  return nodes;
}

}  // namespace fracture
