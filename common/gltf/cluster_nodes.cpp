#include "common/gltf/cluster_nodes.hpp"

#include <set>
#include <string_view>

#include "common/base/pacer.hpp"
#include "common/gltf/fracture_extras.hpp"
#include "common/gltf/names.hpp"

namespace fracture {
namespace {

/// Returns a prefix that no name made from the source's names has: Cluster_, or otherwise Cluster<number>_ with
/// the lowest free number from 2 on.
std::string free_prefix(const Mesh& source, Pacer& pacer) {
  constexpr std::string_view kWord = "Cluster";
  std::set<std::string> taken;  // texts between that word and the first _ after it
  const auto look_at = [&](const std::string& name) {
    pacer.step(4);
    const std::string kept = kept_name(name);
    if (!kept.starts_with(kWord)) return;
    if (const std::size_t end = kept.find('_', kWord.size()); end != std::string::npos)
      taken.insert(kept.substr(kWord.size(), end - kWord.size()));
  };
  for (const std::string& name : source.node_names) look_at(name);
  for (const EmptyNode& node : source.empty_nodes) look_at(node.name);
  std::string number;
  for (std::size_t next = 2; taken.contains(number); ++next) number = std::to_string(next);
  return std::string(kWord) + number + "_";
}

}  // namespace

ClusterNodes::ClusterNodes(const FracturedSolid& fractured, std::size_t first_node,
                           const Execution& execution)
    : hierarchy_(fractured.hierarchy) {
  Pacer pacer(execution);
  prefix_ = free_prefix(*fractured.set.source, pacer);
  std::vector<std::size_t> begin;  // per level: index of its first node in nodes_
  for (std::size_t level = 0; level < hierarchy_.levels.size(); ++level) {
    begin.push_back(nodes_.size());
    for (std::size_t c = 0; c < hierarchy_.levels[level].clusters.size(); ++c) {
      pacer.step(4);
      const std::size_t node = first_node + nodes_.size();
      const std::uint32_t parent = hierarchy_.levels[level].clusters[c].parent;
      (level == 0 ? roots_ : nodes_[begin[level - 1] + parent].children).push_back(node);
      nodes_.push_back({level, c, {}});
    }
  }
  for (std::size_t f = 0; f < fractured.set.fragments.size(); ++f) {
    pacer.step();
    (nodes_.empty() ? roots_ : nodes_[begin.back() + hierarchy_.cluster_of_fragment[f]].children)
        .push_back(1 + f);
  }
}

void ClusterNodes::write(JsonText& json, const GltfOptions& options) const {
  for (const Node& node : nodes_) {
    const std::size_t width = std::to_string(hierarchy_.levels[node.level].clusters.size() - 1).size();
    json.begin_object().member("name",
                               prefix_ + std::to_string(node.level) + "_" + padded(node.cluster, width));
    json.key("children").begin_array();
    for (const std::size_t child : node.children) json.value(child);
    json.end_array();
    json.key("extras").begin_object().key("fracture");
    write_cluster_extras(json, hierarchy_, node.level, node.cluster, options);
    json.end_object().end_object();
  }
}

}  // namespace fracture
