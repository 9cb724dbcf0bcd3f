#include "common/pipeline/unnamed_nodes.hpp"

#include <set>
#include <string_view>

#include "common/base/pacer.hpp"
#include "common/mesh/source_tree.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

void add_unnamed_nodes(const Mesh& source, const std::vector<std::uint32_t>& nodes, const FragmentSet& set,
                       std::vector<Dropped>& dropped, const Execution& execution) {
  Pacer pacer(execution);
  const std::size_t count = source.node_names.size();
  std::vector<bool> has_triangles(count), is_named(count);
  const auto mark = [&](std::vector<bool>& marks, const std::vector<std::uint32_t>& of) {
    pacer.each(0, of.size(), [&](std::size_t k) {
      if (of[k] < count) marks[of[k]] = true;
    });
  };
  mark(has_triangles, source.node);
  mark(is_named, nodes);
  if (source.passed_through) mark(is_named, source.passed_through->node);
  if (set.whole_sheets)
    pacer.each(0, set.whole_sheets->triangles.size(), [&](std::size_t k) {
      const std::uint32_t triangle = set.whole_sheets->triangles[k];
      if (triangle < source.node.size() && source.node[triangle] < count)
        is_named[source.node[triangle]] = true;
    });

  std::set<std::string_view> names;  // two nodes may have one name
  for (std::size_t k = 0; k < count; ++k) {
    pacer.step(8);
    if (is_named[k]) names.insert(source.node_names[k]);
  }
  for (std::size_t k = 0; k < count; ++k) {
    pacer.step();
    if (!has_triangles[k] || is_named[k]) continue;
    const std::string& name = source.node_names[k];
    if (!names.contains(name))
      dropped.push_back(
          {"node", name,
           "no fragment is named after it: its surface is in fragments of other nodes, or was left out"});
    if (k < source.node_extras.size() && !source.node_extras[k].empty())
      dropped.push_back({"extras", name, "no fragment is named after their node"});
  }
  shorten_dropped(dropped);
}

void add_nodes_without_group(const Mesh& source, std::vector<Dropped>& dropped, const Execution& execution) {
  if (!source.source_tree) return;
  Pacer pacer(execution);
  const SourceTree& tree = *source.source_tree;
  std::vector<bool> has_mesh(tree.nodes.size()), is_above(tree.nodes.size());
  pacer.each(0, tree.of_instance.size(), [&](std::size_t k) { has_mesh[tree.of_instance[k]] = true; });
  const SourceNodes nodes(source);
  for (const Mesh* mesh : {&source, source.passed_through.get()}) {
    if (mesh == nullptr) continue;
    pacer.each(0, mesh->node.size(), [&](std::size_t t) {
      const std::uint32_t own = nodes.of_instance(mesh->node[t]);
      if (own == kNoIndex) return;
      for (std::uint32_t n = tree.nodes[own].parent; n != kNoIndex && !is_above[n]; n = tree.nodes[n].parent)
        is_above[n] = true;
    });
  }
  for (std::size_t k = 0; k < tree.nodes.size(); ++k) {
    pacer.step(8);
    if (has_mesh[k] || !is_above[k]) continue;
    const SourceNode& node = tree.nodes[k];
    dropped.push_back({"node", node.name, "answers with levels have no groups"});
    if (!node.extras.empty()) dropped.push_back({"extras", node.name, "answers with levels have no groups"});
  }
  shorten_dropped(dropped);
}

}  // namespace fracture
