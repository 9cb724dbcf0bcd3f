#include "common/clip/crossing_table.hpp"

#include <algorithm>

#include "common/base/pacer.hpp"
#include "common/base/work_blocks.hpp"
#include "common/exact/side.hpp"

namespace fracture::clip_detail {
namespace {

exact::Triangle corners(const Solid& solid, std::uint32_t t) {
  const auto& v = solid.triangles[t];
  return {to_double(solid.positions[v[0]]), to_double(solid.positions[v[1]]),
          to_double(solid.positions[v[2]])};
}

/// Whether (a, b, c) is a rotation of its ascending order.
bool is_even(const std::array<SiteId, 3>& s) { return (s[0] < s[1]) == ((s[1] < s[2]) == (s[0] < s[2])); }

/// Collects the Voronoi edges of a range of cells. Each edge belongs to its lowest cell.
class EdgeCollector {
 public:
  EdgeCollector(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                const Execution& execution, CrossingTable& out)
      : solid_(solid),
        diagram_(diagram),
        table_(cuts.triangle_cuts),
        execution_(execution),
        pacer_(execution),
        out_(out) {}

  using Iterator = std::vector<std::uint32_t>::iterator;
  /// Processes all C vertices with the same lowest site.
  void add_cell(Iterator begin, Iterator end) {
    pacer_.step(8 * static_cast<std::uint64_t>(end - begin));
    sort_with_polls(execution_, begin, end, [&](std::uint32_t a, std::uint32_t b) {
      if (table_[a].sites != table_[b].sites) return table_[a].sites < table_[b].sites;
      if (const auto la = layer_of(a), lb = layer_of(b); la != lb) return la < lb;
      return a < b;
    });
    while (begin != end) {
      const auto& sites = table_[*begin].sites;
      const Iterator next =
          std::find_if(begin, end, [&](std::uint32_t c) { return table_[c].sites != sites; });
      add_edge(sites, begin, next);
      begin = next;
    }
  }

 private:
  std::uint32_t layer_of(std::uint32_t c) const {
    return solid_.parts[solid_.part[table_[c].triangle]].layer;
  }

  void add_edge(const std::array<SiteId, 3>& sites, Iterator begin, Iterator end) {
    const VoronoiDiagram::Facet facet = diagram_.find_facet(sites[0], sites[1], sites[2]);
    CrossedEdge edge{static_cast<std::uint32_t>(out_.layers.size()), 0, facet.tet, facet.face,
                     is_even(outward_facet(diagram_.dual().tets[facet.tet], facet.face))};
    while (begin != end) {
      const std::uint32_t layer = layer_of(*begin);
      const Iterator next = std::find_if(begin, end, [&](std::uint32_t c) { return layer_of(c) != layer; });
      add_layer(sites, layer, begin, next);
      ++edge.count;
      begin = next;
    }
    out_.edges.push_back(edge);
  }

  void add_layer(const std::array<SiteId, 3>& sites, std::uint32_t layer, Iterator begin, Iterator end) {
    const Vec3d &i = diagram_.site(sites[0]), &j = diagram_.site(sites[1]), &k = diagram_.site(sites[2]);
    std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
      pacer_.step(16);
      const std::uint32_t ta = table_[a].triangle, tb = table_[b].triangle;
      if (const int s = exact::order_on_edge(i, j, k, corners(solid_, ta), corners(solid_, tb))) return s < 0;
      return ta < tb;
    });
    LayerCrossings crossings{layer, static_cast<std::uint32_t>(out_.crossings.size()),
                             static_cast<std::uint32_t>(end - begin), 0};
    for (Iterator c = begin; c != end; ++c) {
      pacer_.step(8);
      const exact::Triangle t = corners(solid_, table_[*c].triangle);
      const int sign = exact::crossing_sign(t.a, t.b, t.c, i, j, k);
      out_.crossings.push_back({*c, -sign});
      crossings.jump -= sign;
    }
    out_.layers.push_back(crossings);
  }

  const Solid& solid_;
  const VoronoiDiagram& diagram_;
  const std::vector<TriangleCut>& table_;
  const Execution& execution_;
  Pacer pacer_;
  CrossingTable& out_;
};

}  // namespace

CrossingTable find_crossings(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                             const std::vector<char>* wanted, const Execution& execution) {
  // Counting sort by lowest site.
  const auto& table = cuts.triangle_cuts;
  const std::uint32_t sites = diagram.dual().site_count();
  Pacer pacer(execution);
  std::vector<std::uint32_t> begin(sites + 1, 0);
  const auto each = [&](const auto& visit) {
    for (std::uint32_t c = 0; c < table.size(); ++c) {
      pacer.step();
      const auto& s = table[c].sites;
      if (wanted && !(*wanted)[s[0]] && !(*wanted)[s[1]] && !(*wanted)[s[2]]) continue;
      visit(s[0], c);
    }
  };
  each([&](SiteId lowest, std::uint32_t) { ++begin[lowest + 1]; });
  for (std::uint32_t s = 0; s < sites; ++s) begin[s + 1] += begin[s];
  std::vector<std::uint32_t> order(begin[sites]), next(begin.begin(), begin.end() - 1);
  each([&](SiteId lowest, std::uint32_t c) { order[next[lowest]++] = c; });

  const WorkBlocks blocks(execution, sites, 200'000, [&](std::size_t s) {
    return 2 + 1000 * static_cast<std::uint64_t>(begin[s + 1] - begin[s]);
  });
  std::vector<CrossingTable> found(blocks.count());
  parallel_for_blocks(execution, blocks, [&](std::size_t block, std::size_t first, std::size_t last) {
    EdgeCollector collector(solid, diagram, cuts, execution, found[block]);
    for (std::size_t s = first; s < last; ++s)
      collector.add_cell(order.begin() + begin[s], order.begin() + begin[s + 1]);
  });

  CrossingTable out;
  for (const CrossingTable& block : found) {
    const auto layer_base = static_cast<std::uint32_t>(out.layers.size());
    const auto crossing_base = static_cast<std::uint32_t>(out.crossings.size());
    pacer.step(block.edges.size() + block.layers.size() + block.crossings.size());
    for (CrossedEdge e : block.edges) {
      e.first += layer_base;
      out.edges.push_back(e);
    }
    for (LayerCrossings l : block.layers) {
      l.first += crossing_base;
      out.layers.push_back(l);
    }
    out.crossings.insert(out.crossings.end(), block.crossings.begin(), block.crossings.end());
  }
  return out;
}

}  // namespace fracture::clip_detail
