#include "common/gltf/group_nodes.hpp"

#include <map>
#include <set>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/gltf/names.hpp"
#include "common/gltf/unique_names.hpp"
#include "common/mesh/copied_limits.hpp"
#include "common/solid/solid.hpp"

namespace fracture {
namespace {

/// Appended to the name of a group if something else has the name.
constexpr std::string_view kSuffix = "_group";

/// Returns a name for each node of the source. Names depend only on the source. They are those of the fragments without their
/// numbers, as far as possible; nodes with equal names are numbered (_2, _3, …).
std::vector<std::string> names_of_groups(const SourceNodes& nodes, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::string> sources;
  sources.reserve(nodes.size());
  for (std::uint32_t k = 0; k < nodes.size(); ++k) {
    pacer.step(4);
    sources.push_back(nodes.name(k));
  }
  constexpr std::size_t kRoom = kMaxName - kSuffix.size();
  std::vector<std::string> names = names_of_sources(sources, kRoom, execution);
  std::set<std::string> taken;
  for (const std::string& name : names) {
    pacer.step(16);
    taken.insert(name);
  }
  std::map<std::string, std::size_t> last_number;  // per name; 0: no group has it yet
  for (std::string& name : names) {
    pacer.step(16);
    std::size_t& number = last_number.try_emplace(name, 0).first->second;
    if (number++ == 0) continue;
    for (const std::string wanted = name;; ++number) {
      const std::string end = "_" + std::to_string(number);
      name = kept_name(wanted, kRoom - end.size()) + end;
      if (taken.insert(name).second) break;
    }
  }
  return names;
}

/// Marks the nodes of the source that need a group whatever the fragments are: those with triangles that are broken, and those above
/// others. The other nodes that stay whole are nodes of the answer as they are.
std::vector<char> mark_groups(const FragmentSet& set, const SourceNodes& nodes, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<std::size_t> broken(nodes.size(), 0);  // triangles
  std::vector<char> has_triangles(nodes.size(), 0), marked(nodes.size(), 0);
  const auto each = [&](const Mesh& mesh, const auto& visit) {
    pacer.each(0, mesh.node.size(), [&](std::size_t t) {
      if (const std::uint32_t node = nodes.of_instance(mesh.node[t]); node != kNoIndex) visit(node);
    });
  };
  each(*set.source, [&](std::uint32_t node) { ++broken[node]; });
  if (set.source->passed_through)
    each(*set.source->passed_through, [&](std::uint32_t node) { has_triangles[node] = 1; });
  for (std::size_t k = 0; k < broken.size(); ++k)
    if (broken[k] > 0) has_triangles[k] = 1;
  if (set.whole_sheets) {
    const std::vector<std::uint32_t>& instances = set.whole_sheets->surface->source->node;
    for (const std::uint32_t t : set.whole_sheets->triangles) {
      pacer.step();
      const std::uint32_t node = nodes.of_instance(t < instances.size() ? instances[t] : kNoIndex);
      if (node != kNoIndex && broken[node] > 0) --broken[node];
    }
  }
  for (std::size_t k = nodes.size(); k-- > 0;) {  // children come after their parents
    const std::uint32_t parent = nodes.parent(static_cast<std::uint32_t>(k));
    if (broken[k] > 0) marked[k] = 1;
    if (parent == kNoIndex || !(marked[k] || has_triangles[k])) continue;
    marked[parent] = 1;
  }
  return marked;
}

}  // namespace

SourceOfFragments::SourceOfFragments(const FragmentSet& set, const Execution& execution)
    : nodes_(*set.source), is_hierarchy_(!set.fragments.empty() && nodes_.is_hierarchy(execution)) {
  if (!is_hierarchy_) return;
  Pacer pacer(execution);
  of_fragment_.reserve(set.fragments.size());
  for (const Fragment& f : set.fragments) {
    pacer.step(4);
    NodeRange instances = f.nodes;
    instances.add(f.node);
    of_fragment_.push_back(nodes_.common_ancestor(instances));
  }
}

void SourceOfFragments::write(JsonText& json, std::uint32_t node) const {
  if (node == kNoIndex) return;
  json.key("source").begin_object().member("index", node);
  json.member("name", node_name_within_limit(nodes_.name(node))).end_object();
}

void GroupNodes::place(std::uint32_t source, std::size_t node, std::vector<std::vector<std::size_t>>& held) {
  (source == kNoIndex ? of_root_ : held[source]).push_back(node);
}

GroupNodes::GroupNodes(const FracturedSolid& fractured, const SourceOfFragments& sources,
                       const SceneLayout& layout, const std::vector<WholeNode>& whole,
                       const IntactScene& intact, const EmptyNodes& empty,
                       const std::vector<std::size_t>& top, std::size_t first_node,
                       const Execution& execution)
    : sources_(sources) {
  const std::size_t fragments = fractured.set.fragments.size(), first_whole = layout.node_count();
  const auto add_empty_nodes = [&] {
    for (std::size_t k = 0; k < empty.size(); ++k) of_root_.push_back(empty.first_node() + k);
  };
  if (!sources.is_hierarchy() || !fractured.hierarchy.levels.empty()) {
    of_root_ = top;
    for (std::size_t k = 0; k < whole.size(); ++k) of_root_.push_back(first_whole + k);
    add_empty_nodes();
    return;
  }
  Pacer pacer(execution);
  const SourceNodes& nodes = sources.nodes();
  std::vector<std::vector<std::size_t>> held(nodes.size());  // per node of the source: nodes of the answer
  for (std::size_t k = 0; k < fragments; ++k) {
    pacer.step(4);
    place(sources.of(k), 1 + k, held);
  }
  const std::vector<char> is_group =
      whole.empty() ? std::vector<char>() : mark_groups(fractured.set, nodes, execution);
  for (std::size_t k = 0; k < whole.size(); ++k) {
    pacer.step(4);
    std::uint32_t source = nodes.of_instance(whole[k].node);
    if (source != kNoIndex && !is_group[source]) source = nodes.parent(source);
    place(source, first_whole + k, held);
  }
  add_empty_nodes();

  std::vector<char> used(nodes.size(), 0);
  for (std::size_t k = nodes.size(); k-- > 0;) {
    pacer.step();
    const std::uint32_t parent = nodes.parent(static_cast<std::uint32_t>(k));
    if (!held[k].empty()) used[k] = 1;
    if (used[k] && parent != kNoIndex) used[parent] = 1;
  }
  const std::vector<std::string> wanted = names_of_groups(nodes, execution);
  UniqueNames names(layout, fragments, execution);
  for (const WholeNode& node : whole) names.take(node.name);
  for (const std::string& name : empty.names()) names.take(name);
  intact.take_names(names);
  for (std::uint32_t k = 0; k < nodes.size(); ++k) {
    pacer.step(8);
    if (!used[k]) continue;
    const std::size_t node = first_node + groups_.size();
    const bool is_free = names.take(wanted[k]);
    groups_.push_back({k, is_free ? wanted[k] : names.add(wanted[k], kSuffix), {}});
    place(nodes.parent(k), node, held);  // its group comes before
  }
  for (Group& group : groups_) group.children = std::move(held[group.source]);
}

void GroupNodes::write(JsonText& json) const {
  const SourceNodes& nodes = sources_.nodes();
  for (const Group& group : groups_) {
    json.begin_object().member("name", group.name).key("children").begin_array();
    for (const std::size_t child : group.children) json.value(child);
    json.end_array().key("extras").begin_object().key("fracture").begin_object();
    sources_.write(json, group.source);
    json.end_object();
    if (!nodes.extras(group.source).empty()) json.value_text(nodes.extras(group.source));
    json.end_object().end_object();
  }
}

}  // namespace fracture
