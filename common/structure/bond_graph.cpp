#include "common/structure/bond_graph.hpp"

#include <algorithm>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"

namespace fracture {

BondGraph::BondGraph(std::vector<Node> nodes, const std::vector<Bond>& bonds, const Execution& execution)
    : nodes_(std::move(nodes)), begin_(nodes_.size() + 1, 0), edges_(2 * bonds.size()) {
  Pacer pacer(execution);
  for (const Bond& b : bonds) {
    pacer.step();
    ++begin_[b.a + 1];
    ++begin_[b.b + 1];
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) begin_[n + 1] += begin_[n];
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t k = 0; k < bonds.size(); ++k) {
    pacer.step(2);
    edges_[next[bonds[k].a]++] = {bonds[k].b, k, bonds[k].area};
    edges_[next[bonds[k].b]++] = {bonds[k].a, k, bonds[k].area};
  }
}

BondGraph BondGraph::of_fragments(const FragmentSet& set, const Execution& execution) {
  std::vector<Node> nodes;
  nodes.reserve(set.fragments.size());
  for (const Fragment& f : set.fragments) nodes.push_back({f.mass.volume, f.mass.center_of_mass});
  return {std::move(nodes), set.bonds, execution};
}

std::vector<std::uint32_t> BondGraph::components(const Execution& execution) const {
  Pacer pacer(execution);
  DisjointSets sets(size());
  for (std::uint32_t n = 0; n < size(); ++n) {
    pacer.step(1 + edges(n).size());
    for (const Edge& e : edges(n)) sets.unite(n, e.to);
  }
  std::vector<std::uint32_t> component(size());
  for (std::uint32_t n = 0; n < size(); ++n) component[n] = sets.find(n);
  return component;
}

std::vector<Bond> bonds_between(const std::vector<Bond>& bonds,
                                const std::vector<std::uint32_t>& group_of_node, const Execution& execution) {
  Pacer pacer(execution);
  struct Part {
    std::uint32_t a, b, bond;
    bool reversed;
  };
  std::vector<Part> parts;
  for (std::uint32_t k = 0; k < bonds.size(); ++k) {
    pacer.step();
    const std::uint32_t a = group_of_node[bonds[k].a], b = group_of_node[bonds[k].b];
    if (a != b) parts.push_back({std::min(a, b), std::max(a, b), k, a > b});
  }
  sort_with_polls(execution, parts.begin(), parts.end(), [](const Part& x, const Part& y) {
    if (x.a != y.a) return x.a < y.a;
    if (x.b != y.b) return x.b < y.b;
    return x.bond < y.bond;
  });
  std::vector<Bond> out;
  for (std::size_t k = 0; k < parts.size();) {
    Bond sum{parts[k].a, parts[k].b, 0, {}, {}};
    Vec3d moment, normal;
    double strength = 0;
    for (; k < parts.size() && parts[k].a == sum.a && parts[k].b == sum.b; ++k) {
      pacer.step();
      const Bond& b = bonds[parts[k].bond];
      sum.area += b.area;
      strength += b.area * b.strength;
      moment = moment + b.area * b.centroid;
      normal = normal + (parts[k].reversed ? -b.area : b.area) * b.normal;
    }
    sum.strength = strength / sum.area;
    sum.centroid = (1 / sum.area) * moment;
    const double l = length(normal);
    sum.normal = l > 0 ? (1 / l) * normal : Vec3d{0, 0, 1};
    out.push_back(sum);
  }
  return out;
}

}  // namespace fracture
