#include "common/structure/clusters.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <queue>
#include <utility>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

constexpr int kPasses = 6;  // passes that move the centres; the regions hardly change after four

double distance2(const Vec3d& a, const Vec3d& b) { return dot(a - b, a - b); }

/// Divides at least `count` nodes by recursive coordinate bisection into `count` parts of about the same
/// volume, numbered from `first`.
void bisect(const std::vector<BondGraph::Node>& nodes, std::uint32_t* begin, std::uint32_t* end,
            std::uint32_t first, std::uint32_t count, std::vector<std::uint32_t>& part_of_node,
            const Execution& execution) {
  execution.poll();
  if (count == 1) {
    for (std::uint32_t* n = begin; n != end; ++n) part_of_node[*n] = first;
    return;
  }
  Box box;
  double volume = 0;
  for (const std::uint32_t* n = begin; n != end; ++n) {
    box.add(nodes[*n].center);
    volume += nodes[*n].volume;
  }
  const Vec3d size = box.size();
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (size[a] > size[axis]) axis = a;
  sort_with_polls(execution, begin, end, [&](std::uint32_t a, std::uint32_t b) {
    const double x = nodes[a].center[axis], y = nodes[b].center[axis];
    return x != y ? x < y : a < b;
  });
  const std::uint32_t low = count / 2, high = count - low;
  const double wanted = volume * low / count;
  std::uint32_t* middle = begin;
  for (double below = 0; middle != end; ++middle) {
    const double next = below + nodes[*middle].volume;
    if (next - wanted > wanted - below) break;  // one more would be farther from the wanted volume
    below = next;
  }
  middle = std::clamp(middle, begin + low, end - high);
  bisect(nodes, begin, middle, first, low, part_of_node, execution);
  bisect(nodes, middle, end, first + low, high, part_of_node, execution);
}

/// Returns the number of clusters for each component: one each, and the others one by one where the volume
/// per cluster is largest.
std::vector<std::uint32_t> shares(const std::vector<double>& volume, const std::vector<std::uint32_t>& nodes,
                                  std::uint32_t count, Pacer& pacer) {
  struct Claim {
    double volume;
    std::uint32_t component;
    bool operator<(const Claim& o) const {
      return volume != o.volume ? volume < o.volume : component > o.component;
    }
  };
  std::vector<std::uint32_t> share(volume.size(), 1);
  std::priority_queue<Claim> claims;
  const auto claim = [&](std::uint32_t c) {
    if (share[c] < nodes[c]) claims.push({volume[c] / share[c], c});
  };
  for (std::uint32_t c = 0; c < volume.size(); ++c) claim(c);
  for (auto left = count - static_cast<std::uint32_t>(volume.size()); left > 0 && !claims.empty(); --left) {
    pacer.step(4);
    const std::uint32_t c = claims.top().component;
    claims.pop();
    ++share[c];
    claim(c);
  }
  return share;
}

/// Returns the centroid of each cluster.
std::vector<Vec3d> centers_of(const BondGraph& graph, const std::vector<std::uint32_t>& cluster,
                              std::uint32_t count, Pacer& pacer) {
  std::vector<Vec3d> moment(count);
  std::vector<double> volume(count, 0);
  for (std::uint32_t n = 0; n < graph.size(); ++n) {
    pacer.step();
    moment[cluster[n]] = moment[cluster[n]] + graph.node(n).volume * graph.node(n).center;
    volume[cluster[n]] += graph.node(n).volume;
  }
  for (std::uint32_t c = 0; c < count; ++c)
    if (volume[c] > 0) moment[c] = (1 / volume[c]) * moment[c];
  return moment;
}

/// Total area of the bonds between a node that is not taken yet and a cluster. For a node with few bonds,
/// the area is summed on each query. For a node with many bonds it is stored, because each of its
/// neighbours queries it.
class Bound {
 public:
  explicit Bound(const BondGraph& graph) : graph_(graph) {}

  static constexpr std::size_t kManyBonds = 64;

  void take(std::uint32_t node, std::uint32_t cluster) {
    for (const BondGraph::Edge& e : graph_.edges(node))
      if (graph_.edges(e.to).size() > kManyBonds) of_many_[{e.to, cluster}] += e.area;
  }
  double of(std::uint32_t node, std::uint32_t cluster, const std::vector<std::uint32_t>& grown) const {
    if (graph_.edges(node).size() > kManyBonds) return of_many_.at({node, cluster});
    double bound = 0;
    for (const BondGraph::Edge& back : graph_.edges(node))
      if (grown[back.to] == cluster) bound += back.area;
    return bound;
  }

 private:
  const BondGraph& graph_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> of_many_;  // node, cluster
};

/// Grows regions over the bonds, each from the node nearest to its centre, until all nodes are taken.
/// `area`: per node, the area of all its bonds.
std::vector<std::uint32_t> grow(const BondGraph& graph, const std::vector<double>& area,
                                const std::vector<std::uint32_t>& cluster, const std::vector<Vec3d>& centers,
                                Pacer& pacer) {
  const std::uint32_t n = graph.size();
  std::vector<std::uint32_t> seed(centers.size(), kNoIndex);
  for (std::uint32_t v = 0; v < n; ++v) {
    pacer.step();
    std::uint32_t& s = seed[cluster[v]];
    const Vec3d& center = centers[cluster[v]];
    if (s == kNoIndex || distance2(graph.node(v).center, center) < distance2(graph.node(s).center, center))
      s = v;
  }
  struct Offer {
    double cost;
    std::uint32_t cluster, node;
    bool operator<(const Offer& o) const {  // the cheapest offer is on top
      if (cost != o.cost) return cost > o.cost;
      return cluster != o.cluster ? cluster > o.cluster : node > o.node;
    }
  };
  std::vector<std::uint32_t> grown(n, kNoIndex);
  Bound bound(graph);
  std::priority_queue<Offer> offers;
  for (std::uint32_t c = 0; c < seed.size(); ++c) offers.push({-1, c, seed[c]});
  while (!offers.empty()) {
    const Offer offer = offers.top();
    offers.pop();
    pacer.step(16);
    if (grown[offer.node] != kNoIndex) continue;
    grown[offer.node] = offer.cluster;
    bound.take(offer.node, offer.cluster);
    for (const BondGraph::Edge& e : graph.edges(offer.node)) {
      if (grown[e.to] != kNoIndex) continue;
      pacer.step(8 + std::min(graph.edges(e.to).size(), Bound::kManyBonds));
      // A node that is bound to the cluster by all of its area seems half as far.
      const double share = area[e.to] > 0 ? bound.of(e.to, offer.cluster, grown) / area[e.to] : 0;
      offers.push({distance2(graph.node(e.to).center, centers[offer.cluster]) * (1 - 0.75 * share),
                   offer.cluster, e.to});
    }
  }
  return grown;
}

std::vector<std::uint32_t> numbered_by_lowest(const std::vector<std::uint32_t>& cluster,
                                              std::uint32_t count) {
  std::vector<std::uint32_t> number(count, kNoIndex), out(cluster.size());
  std::uint32_t next = 0;
  for (std::size_t n = 0; n < cluster.size(); ++n) {
    std::uint32_t& c = number[cluster[n]];
    if (c == kNoIndex) c = next++;
    out[n] = c;
  }
  return out;
}

}  // namespace

std::vector<std::uint32_t> find_clusters(const BondGraph& graph, std::uint32_t count,
                                         const Execution& execution) {
  Pacer pacer(execution);
  const std::uint32_t n = graph.size();
  std::vector<std::uint32_t> cluster(n);
  std::iota(cluster.begin(), cluster.end(), 0u);
  if (count >= n) return cluster;

  // The numbered components with their nodes.
  const std::vector<std::uint32_t> lowest = graph.components(execution);
  const std::vector<std::uint32_t> component = numbered_by_lowest(lowest, n);
  const std::uint32_t components = 1 + *std::max_element(component.begin(), component.end());
  std::vector<std::vector<std::uint32_t>> nodes_of(components);
  for (std::uint32_t v = 0; v < n; ++v) nodes_of[component[v]].push_back(v);
  std::vector<double> volume(components, 0);
  std::vector<std::uint32_t> size(components);
  for (std::uint32_t c = 0; c < components; ++c) {
    for (const std::uint32_t v : nodes_of[c]) volume[c] += graph.node(v).volume;
    size[c] = static_cast<std::uint32_t>(nodes_of[c].size());
  }

  if (components >= count) {
    const std::vector<Vec3d> centers = centers_of(graph, component, components, pacer);
    std::vector<BondGraph::Node> whole(components);
    for (std::uint32_t c = 0; c < components; ++c) whole[c] = {volume[c], centers[c]};
    std::vector<std::uint32_t> order(components), group(components);
    std::iota(order.begin(), order.end(), 0u);
    bisect(whole, order.data(), order.data() + components, 0, count, group, execution);
    for (std::uint32_t v = 0; v < n; ++v) cluster[v] = group[component[v]];
    return numbered_by_lowest(cluster, count);
  }

  std::vector<BondGraph::Node> nodes(n);
  for (std::uint32_t v = 0; v < n; ++v) nodes[v] = graph.node(v);
  const std::vector<std::uint32_t> share = shares(volume, size, count, pacer);
  std::uint32_t first = 0;
  for (std::uint32_t c = 0; c < components; first += share[c++])
    bisect(nodes, nodes_of[c].data(), nodes_of[c].data() + nodes_of[c].size(), first, share[c], cluster,
           execution);
  // The parts of the bisection need not be connected, so only regions grown over bonds are kept.
  std::vector<double> area(n, 0);
  for (std::uint32_t v = 0; v < n; ++v) {
    pacer.step(1 + graph.edges(v).size());
    for (const BondGraph::Edge& e : graph.edges(v)) area[v] += e.area;
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<std::uint32_t> grown =
        grow(graph, area, cluster, centers_of(graph, cluster, count, pacer), pacer);
    const bool settled = grown == cluster;
    cluster = std::move(grown);
    if (settled) break;
  }
  return numbered_by_lowest(cluster, count);
}

}  // namespace fracture
