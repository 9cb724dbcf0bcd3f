#include "common/structure/clusters.hpp"

#include <algorithm>
#include <numeric>
#include <queue>

namespace fracture {
namespace {

constexpr int kPasses = 6;  // of moving the centres; the regions hardly change after four

double distance2(const Vec3d& a, const Vec3d& b) { return dot(a - b, a - b); }

/// Recursive coordinate bisection of some nodes into `count` parts of about the same volume, numbered from
/// `first` on. At least `count` nodes.
void bisect(const std::vector<BondGraph::Node>& nodes, std::uint32_t* begin, std::uint32_t* end,
            std::uint32_t first, std::uint32_t count, std::vector<std::uint32_t>& part_of_node) {
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
  std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
    const double x = nodes[a].center[axis], y = nodes[b].center[axis];
    return x != y ? x < y : a < b;
  });
  const std::uint32_t low = count / 2, high = count - low;
  const double wanted = volume * low / count;
  std::uint32_t* middle = begin;
  for (double below = 0; middle != end; ++middle) {
    const double next = below + nodes[*middle].volume;
    if (next - wanted > wanted - below) break;  // one more is farther from what is wanted
    below = next;
  }
  middle = std::clamp(middle, begin + low, end - high);
  bisect(nodes, begin, middle, first, low, part_of_node);
  bisect(nodes, middle, end, first + low, high, part_of_node);
}

/// How many clusters each component gets: one each, the others one by one where the volume of a cluster is
/// largest.
std::vector<std::uint32_t> shares(const std::vector<double>& volume, const std::vector<std::uint32_t>& nodes,
                                  std::uint32_t count) {
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
    const std::uint32_t c = claims.top().component;
    claims.pop();
    ++share[c];
    claim(c);
  }
  return share;
}

/// The centroid of each cluster.
std::vector<Vec3d> centers_of(const BondGraph& graph, const std::vector<std::uint32_t>& cluster,
                              std::uint32_t count) {
  std::vector<Vec3d> moment(count);
  std::vector<double> volume(count, 0);
  for (std::uint32_t n = 0; n < graph.size(); ++n) {
    moment[cluster[n]] = moment[cluster[n]] + graph.node(n).volume * graph.node(n).center;
    volume[cluster[n]] += graph.node(n).volume;
  }
  for (std::uint32_t c = 0; c < count; ++c)
    if (volume[c] > 0) moment[c] = (1 / volume[c]) * moment[c];
  return moment;
}

/// The regions that grow from the node nearest to each centre over the bonds until all are taken.
std::vector<std::uint32_t> grow(const BondGraph& graph, const std::vector<std::uint32_t>& cluster,
                                const std::vector<Vec3d>& centers) {
  const std::uint32_t n = graph.size();
  std::vector<std::uint32_t> seed(centers.size(), kNoIndex);
  for (std::uint32_t v = 0; v < n; ++v) {
    std::uint32_t& s = seed[cluster[v]];
    const Vec3d& center = centers[cluster[v]];
    if (s == kNoIndex || distance2(graph.node(v).center, center) < distance2(graph.node(s).center, center))
      s = v;
  }
  struct Offer {
    double cost;
    std::uint32_t cluster, node;
    bool operator<(const Offer& o) const {  // the cheapest on top
      if (cost != o.cost) return cost > o.cost;
      return cluster != o.cluster ? cluster > o.cluster : node > o.node;
    }
  };
  std::vector<std::uint32_t> grown(n, kNoIndex);
  std::priority_queue<Offer> offers;
  for (std::uint32_t c = 0; c < seed.size(); ++c) offers.push({-1, c, seed[c]});
  while (!offers.empty()) {
    const Offer offer = offers.top();
    offers.pop();
    if (grown[offer.node] != kNoIndex) continue;
    grown[offer.node] = offer.cluster;
    for (const BondGraph::Edge& e : graph.edges(offer.node)) {
      if (grown[e.to] != kNoIndex) continue;
      double bound = 0, all = 0;
      for (const BondGraph::Edge& back : graph.edges(e.to)) {
        all += back.area;
        if (grown[back.to] == offer.cluster) bound += back.area;
      }
      // A node bound to the cluster by all of its area seems half as far.
      const double share = all > 0 ? bound / all : 0;
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
  const std::uint32_t n = graph.size();
  std::vector<std::uint32_t> cluster(n);
  std::iota(cluster.begin(), cluster.end(), 0u);
  if (count >= n) return cluster;

  // The components, numbered, with their nodes.
  const std::vector<std::uint32_t> lowest = graph.components();
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
    const std::vector<Vec3d> centers = centers_of(graph, component, components);
    std::vector<BondGraph::Node> whole(components);
    for (std::uint32_t c = 0; c < components; ++c) whole[c] = {volume[c], centers[c]};
    std::vector<std::uint32_t> order(components), group(components);
    std::iota(order.begin(), order.end(), 0u);
    bisect(whole, order.data(), order.data() + components, 0, count, group);
    for (std::uint32_t v = 0; v < n; ++v) cluster[v] = group[component[v]];
    return numbered_by_lowest(cluster, count);
  }

  std::vector<BondGraph::Node> nodes(n);
  for (std::uint32_t v = 0; v < n; ++v) nodes[v] = graph.node(v);
  const std::vector<std::uint32_t> share = shares(volume, size, count);
  std::uint32_t first = 0;
  for (std::uint32_t c = 0; c < components; first += share[c++])
    bisect(nodes, nodes_of[c].data(), nodes_of[c].data() + nodes_of[c].size(), first, share[c], cluster);
  // The parts of the bisection may hang together by nothing: only regions grown over bonds are kept.
  for (int pass = 0; pass < kPasses; ++pass) {
    execution.poll();
    std::vector<std::uint32_t> grown = grow(graph, cluster, centers_of(graph, cluster, count));
    const bool settled = grown == cluster;
    cluster = std::move(grown);
    if (settled) break;
  }
  return numbered_by_lowest(cluster, count);
}

}  // namespace fracture
