#include "common/structure/hierarchy.hpp"

#include <algorithm>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/random.hpp"
#include "common/structure/bond_graph.hpp"
#include "common/structure/clusters.hpp"

namespace fracture {
namespace {

/// Returns an id that depends on the fragments and the level. So a cluster that contains only one fragment
/// or one cluster has a different id from that.
std::uint64_t cluster_id(std::vector<std::uint64_t> fragments, std::size_t level,
                         const Execution& execution) {
  sort_with_polls(execution, fragments.begin(), fragments.end());
  std::uint64_t h = mix64(0x636c7573746572ull, level);
  for (const std::uint64_t id : fragments) h = mix64(h, id);
  return h >> 11;
}

}  // namespace

Hierarchy make_hierarchy(const FragmentSet& set, const std::vector<std::uint32_t>& counts,
                         const Execution& execution) {
  Hierarchy out;
  if (counts.empty() || set.fragments.empty()) return out;
  out.levels.resize(counts.size());

  // From the fragments upwards: the nodes of a level are the clusters of the finer one.
  const std::size_t fragments = set.fragments.size();
  BondGraph graph = BondGraph::of_fragments(set, execution);
  const std::vector<Bond>* bonds = &set.bonds;
  std::vector<std::vector<std::uint32_t>> members(fragments);  // per node: its fragments
  Pacer pacer(execution);
  for (std::uint32_t f = 0; f < fragments; ++f) {
    pacer.step(4);
    members[f] = {f};
  }
  for (std::size_t level = counts.size(); level-- > 0;) {
    const std::vector<std::uint32_t> cluster = find_clusters(graph, counts[level], execution);
    if (level + 1 == counts.size())
      out.cluster_of_fragment = cluster;
    else
      for (std::uint32_t n = 0; n < graph.size(); ++n) out.levels[level + 1].clusters[n].parent = cluster[n];

    ClusterLevel& here = out.levels[level];
    here.clusters.resize(1 + *std::max_element(cluster.begin(), cluster.end()));
    std::vector<std::vector<std::uint32_t>> of_cluster(here.clusters.size());
    std::vector<Vec3d> moment(here.clusters.size());
    for (std::uint32_t n = 0; n < graph.size(); ++n) {
      pacer.step(4);
      Cluster& c = here.clusters[cluster[n]];
      c.volume += graph.node(n).volume;
      moment[cluster[n]] = moment[cluster[n]] + graph.node(n).volume * graph.node(n).center;
      auto& all = of_cluster[cluster[n]];
      all.insert(all.end(), members[n].begin(), members[n].end());
    }
    std::vector<BondGraph::Node> nodes;
    for (std::size_t c = 0; c < here.clusters.size(); ++c) {
      pacer.step(8 + of_cluster[c].size());
      Cluster& made = here.clusters[c];
      made.parent = kNoIndex;
      made.fragments = static_cast<std::uint32_t>(of_cluster[c].size());
      if (made.volume > 0) made.center_of_mass = (1 / made.volume) * moment[c];
      std::vector<std::uint64_t> ids;
      double less = 0;  // m³ of overlaps, which do not count
      for (const std::uint32_t f : of_cluster[c]) {
        const Fragment& fragment = set.fragments[f];
        ids.push_back(fragment.id);
        less += (1 - fragment.density_share) * fragment.mass.volume;
      }
      if (less != 0) made.density_share = 1 - less / made.volume;
      made.id = cluster_id(std::move(ids), level, execution);
      nodes.push_back({made.volume, made.center_of_mass});
    }
    here.bonds = bonds_between(*bonds, cluster, execution);
    graph = BondGraph(std::move(nodes), here.bonds, execution);
    bonds = &here.bonds;
    members = std::move(of_cluster);
  }
  return out;
}

}  // namespace fracture
