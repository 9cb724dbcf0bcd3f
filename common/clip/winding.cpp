#include "common/clip/winding.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "common/exact/side.hpp"

namespace fracture {
namespace {

/// Where the surface crosses a Voronoi edge: C vertices in order along the direction (j - i) x (k - i), i < j
/// < k.
struct Crossing {
  std::uint32_t cut;  ///< index into SurfaceCuts::triangle_cuts
  int step;           ///< change of w in that direction: +1 enters, -1 leaves
};

/// The crossings of one Voronoi edge by one layer.
struct CrossedEdge {
  std::uint32_t first, count;  ///< range of the sorted crossings
  TetId tet;                   ///< one of its two ends ...
  int face;                    ///< ... and the facet of it that is dual to the edge
  bool forward;                ///< the crossings' direction leads out of `tet` through `face`
  int jump;                    ///< sum of steps
};

exact::Triangle corners(const Solid& solid, std::uint32_t t) {
  const auto& v = solid.triangles[t];
  return {to_double(solid.positions[v[0]]), to_double(solid.positions[v[1]]),
          to_double(solid.positions[v[2]])};
}

/// Sites of the facet opposite vertex `face`, counter-clockwise seen from outside a positive tetrahedron.
std::array<SiteId, 3> outward_facet(const Tetrahedron& t, int face) {
  constexpr int kFacet[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  return {t.v[kFacet[face][0]], t.v[kFacet[face][1]], t.v[kFacet[face][2]]};
}

/// True when (a, b, c) is a rotation of its ascending order.
bool is_even(const std::array<SiteId, 3>& s) { return (s[0] < s[1]) == ((s[1] < s[2]) == (s[0] < s[2])); }

/// All crossings, by Voronoi edge and layer, in order along each edge.
class CrossingTable {
 public:
  /// `of_interest` (per site; null: all): Voronoi edges of other cells alone are left out.
  CrossingTable(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                const std::vector<char>* of_interest) {
    const auto& table = cuts.triangle_cuts;
    std::vector<std::uint32_t> order(table.size());
    std::iota(order.begin(), order.end(), 0u);
    if (of_interest)
      std::erase_if(order, [&](std::uint32_t c) {
        const auto& s = table[c].sites;
        return !(*of_interest)[s[0]] && !(*of_interest)[s[1]] && !(*of_interest)[s[2]];
      });
    const auto layer_of = [&](std::uint32_t c) { return solid.parts[solid.part[table[c].triangle]].layer; };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (const auto la = layer_of(a), lb = layer_of(b); la != lb) return la < lb;
      if (table[a].sites != table[b].sites) return table[a].sites < table[b].sites;
      return a < b;
    });
    layer_begin_.assign(solid.layers + 1, 0);
    for (std::size_t n = 0; n < order.size();) {
      const auto& sites = table[order[n]].sites;
      const std::uint32_t layer = layer_of(order[n]);
      std::size_t end = n + 1;
      while (end < order.size() && table[order[end]].sites == sites && layer_of(order[end]) == layer) ++end;
      add_edge(solid, diagram, cuts, sites, layer, order.begin() + static_cast<std::ptrdiff_t>(n),
               order.begin() + static_cast<std::ptrdiff_t>(end));
      n = end;
    }
    for (std::uint32_t l = 0; l < solid.layers; ++l) layer_begin_[l + 1] += layer_begin_[l];
  }

  std::uint32_t begin(std::uint32_t layer) const { return layer_begin_[layer]; }
  std::uint32_t end(std::uint32_t layer) const { return layer_begin_[layer + 1]; }
  const CrossedEdge& edge(std::uint32_t e) const { return edges_[e]; }
  const Crossing& crossing(std::uint32_t c) const { return crossings_[c]; }

 private:
  template <class Iterator>
  void add_edge(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                const std::array<SiteId, 3>& sites, std::uint32_t layer, Iterator begin, Iterator end) {
    const Vec3d &i = diagram.site(sites[0]), &j = diagram.site(sites[1]), &k = diagram.site(sites[2]);
    std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
      const std::uint32_t ta = cuts.triangle_cuts[a].triangle, tb = cuts.triangle_cuts[b].triangle;
      if (const int s = exact::order_on_edge(i, j, k, corners(solid, ta), corners(solid, tb))) return s < 0;
      return ta < tb;
    });
    const VoronoiDiagram::Facet facet = diagram.find_facet(sites[0], sites[1], sites[2]);
    CrossedEdge edge{static_cast<std::uint32_t>(crossings_.size()),
                     static_cast<std::uint32_t>(end - begin),
                     facet.tet,
                     facet.face,
                     is_even(outward_facet(diagram.dual().tets[facet.tet], facet.face)),
                     0};
    for (Iterator c = begin; c != end; ++c) {
      const exact::Triangle t = corners(solid, cuts.triangle_cuts[*c].triangle);
      const int sign = exact::crossing_sign(t.a, t.b, t.c, i, j, k);
      crossings_.push_back({*c, -sign});
      edge.jump -= sign;
    }
    edges_.push_back(edge);
    ++layer_begin_[layer + 1];
  }

  std::vector<Crossing> crossings_;
  std::vector<CrossedEdge> edges_;
  std::vector<std::uint32_t> layer_begin_;
};

/// One layer: w at every Voronoi vertex, then the intervals with w != 0.
class LayerTraversal {
 public:
  LayerTraversal(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                 const CrossingTable& table, std::uint32_t layer, const WindingBefore* before, Winding& out)
      : solid_(solid),
        tets_(diagram.dual().tets),
        dual_(diagram.dual()),
        cuts_(cuts),
        table_(table),
        layer_(layer),
        before_(before),
        out_(out) {
    crossed_.assign(4 * tets_.size(), kNone);
    for (std::uint32_t e = table.begin(layer); e < table.end(layer); ++e) {
      const CrossedEdge& edge = table.edge(e);
      crossed_[4 * edge.tet + static_cast<std::uint32_t>(edge.face)] = e;
      const TetId other = tets_[edge.tet].n[edge.face];
      crossed_[4 * other + static_cast<std::uint32_t>(back_face(other, edge.tet))] = e;
    }
  }

  void run() {
    wind();
    name_inner_vertices();
    emit_intervals();
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  static constexpr std::int32_t kUnknown = INT32_MIN;

  int back_face(TetId t, TetId neighbor) const {
    for (int f = 0; f < 4; ++f)
      if (tets_[t].n[f] == neighbor) return f;
    throw InternalError("adjacency of tetrahedra is not symmetric");
  }
  bool leads_out_of(const CrossedEdge& edge, TetId t) const { return (edge.tet == t) == edge.forward; }

  bool matters(SiteId s) const { return !before_ || (!dual_.is_corner(s) && before_->of_interest[s]); }
  bool tet_matters(TetId t) const {
    const auto& v = tets_[t].v;
    return matters(v[0]) || matters(v[1]) || matters(v[2]) || matters(v[3]);
  }
  /// Is the Voronoi edge through facet f of t one of a cell that matters?
  bool edge_matters(TetId t, int f) const {
    if (!before_) return true;
    const std::array<SiteId, 3> s = outward_facet(tets_[t], f);
    return matters(s[0]) || matters(s[1]) || matters(s[2]);
  }

  void wind() {
    w_.assign(tets_.size(), kUnknown);
    part_.assign(tets_.size(), kNone);
    std::vector<TetId> queue;
    const auto known = [&](TetId t, std::int32_t w, std::uint32_t part) {
      w_[t] = w;
      part_[t] = part;
      queue.push_back(t);
    };
    if (before_) {
      for (const TetId t : before_->tet_now)
        if (t != kNoTet && tet_matters(t)) w_[t] = 0;
      for (const InnerVertex& v : before_->inner_vertices) {
        const TetId t = before_->tet_now[v.tet];
        if (t == kNoTet || w_[t] == kUnknown || solid_.parts[v.part].layer != layer_) continue;
        w_[t] = v.winding;
        part_[t] = v.part;
      }
      for (TetId t = 0; t < tets_.size(); ++t)
        if (w_[t] != kUnknown) queue.push_back(t);
    }
    for (TetId t = 0; t < tets_.size(); ++t)
      if (w_[t] == kUnknown && tet_matters(t) &&
          std::any_of(tets_[t].v.begin(), tets_[t].v.end(), [&](SiteId s) { return dual_.is_corner(s); }))
        known(t, 0, kNone);
    for (std::size_t n = 0; n < queue.size(); ++n) {
      const TetId t = queue[n];
      for (int f = 0; f < 4; ++f) {
        const TetId u = tets_[t].n[f];
        if (u == kNoTet || !edge_matters(t, f)) continue;
        const std::uint32_t e = crossed_[4 * t + static_cast<std::uint32_t>(f)];
        std::int32_t w = w_[t];
        std::uint32_t part = part_[t];
        if (e != kNone) {
          const CrossedEdge& edge = table_.edge(e);
          const bool out = leads_out_of(edge, t);
          w += out ? edge.jump : -edge.jump;
          part = part_at(out ? edge.first + edge.count - 1 : edge.first);
        }
        if (w_[u] == kUnknown) {
          w_[u] = w;
          part_[u] = w != 0 ? part : kNone;
          queue.push_back(u);
        } else if (w_[u] != w) {
          throw InternalError("winding number differs between two ways to Voronoi vertex " +
                              std::to_string(u) + ": " + std::to_string(w_[u]) + " and " + std::to_string(w));
        }
      }
    }
  }

  std::uint32_t part_at(std::uint32_t crossing) const {
    return solid_.part[cuts_.triangle_cuts[table_.crossing(crossing).cut].triangle];
  }

  void name_inner_vertices() {
    name_.assign(tets_.size(), kNone);
    for (TetId t = 0; t < tets_.size(); ++t)
      if (w_[t] != 0 && w_[t] != kUnknown) {
        name_[t] = cuts_.first_d() + static_cast<VertexId>(out_.inner_vertices.size());
        out_.inner_vertices.push_back({t, part_[t], w_[t]});
      }
  }

  void emit_intervals() {
    for (TetId t = 0; t < tets_.size(); ++t)
      for (int f = 0; f < 4; ++f) {
        const TetId u = tets_[t].n[f];
        if (u == kNoTet || u < t || !edge_matters(t, f)) continue;
        const std::uint32_t e = crossed_[4 * t + static_cast<std::uint32_t>(f)];
        if (e == kNone) {
          if (w_[t] != 0) emit(t, f, name_[t], name_[u], w_[t], part_[t]);
          continue;
        }
        // From t's Voronoi vertex to u's, crossing by crossing.
        const CrossedEdge& edge = table_.edge(e);
        const bool out = leads_out_of(edge, t);
        VertexId from = name_[t];
        std::int32_t w = w_[t];
        for (std::uint32_t n = 0; n < edge.count; ++n) {
          const std::uint32_t c = out ? edge.first + n : edge.first + edge.count - 1 - n;
          const Crossing& crossing = table_.crossing(c);
          const VertexId to = cuts_.first_c() + crossing.cut;
          if (w != 0) emit(t, f, from, to, w, part_at(c));
          w += out ? crossing.step : -crossing.step;
          from = to;
        }
        if (w != 0) emit(t, f, from, name_[u], w, part_[u]);
      }
  }

  // An interval directed out of tetrahedron t through facet f = (a, b, c), counter-clockwise about that
  // direction, is a positive boundary piece of the Voronoi facets (a, b), (b, c), (c, a), each seen with its
  // normal from first to second:
  //
  //            a                    the Voronoi edge points at the reader; facet (a, b) extends to the left,
  //      (a,b) | (c,a)              its normal n leads from a to b, and n x (edge direction) points into it:
  //           \ /                   the interior lies on the left of the edge seen from the tip of n
  //        b --+-- c
  //          (b,c)
  void emit(TetId t, int f, VertexId from, VertexId to, std::int32_t w, std::uint32_t part) {
    const std::array<SiteId, 3> s = outward_facet(tets_[t], f);
    for (int k = 0; k < 3; ++k) {
      const SiteId a = s[k], b = s[(k + 1) % 3];
      if (!matters(a) && !matters(b)) continue;
      if (a < b)
        out_.segments.push_back({a, b, from, to, w, part});
      else
        out_.segments.push_back({b, a, to, from, w, part});
    }
  }

  const Solid& solid_;
  const std::vector<Tetrahedron>& tets_;
  const Tetrahedralization& dual_;
  const SurfaceCuts& cuts_;
  const CrossingTable& table_;
  const std::uint32_t layer_;
  const WindingBefore* const before_;
  Winding& out_;
  std::vector<std::uint32_t> crossed_;  // per facet of each tetrahedron: index of its CrossedEdge
  std::vector<std::int32_t> w_;
  std::vector<std::uint32_t> part_;
  std::vector<VertexId> name_;
};

Winding wind(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
             const WindingBefore* before, const Execution& execution) {
  Winding out;
  const CrossingTable table(solid, diagram, cuts, before ? &before->of_interest : nullptr);
  for (std::uint32_t layer = 0; layer < solid.layers; ++layer) {
    execution.poll();
    LayerTraversal(solid, diagram, cuts, table, layer, before, out).run();
  }
  return out;
}

}  // namespace

Winding wind_voronoi_edges(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                           const Execution& execution) {
  return wind(solid, diagram, cuts, nullptr, execution);
}

Winding wind_voronoi_edges_again(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                                 const WindingBefore& before, const Execution& execution) {
  return wind(solid, diagram, cuts, &before, execution);
}

}  // namespace fracture
