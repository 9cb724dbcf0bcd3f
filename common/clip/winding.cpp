#include "common/clip/winding.hpp"

#include <algorithm>
#include <string>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/clip/crossing_table.hpp"

namespace fracture {
namespace {

using clip_detail::CrossedEdge;
using clip_detail::Crossing;
using clip_detail::CrossingTable;
using clip_detail::LayerCrossings;

/// A layer whose winding number at some vertex is not 0.
struct Inside {
  std::uint32_t layer;
  std::int32_t winding;
  std::uint32_t part;
};

/// w of all layers at all Voronoi vertices, in sparse form. Each vertex has a *state*: the layers that it is
/// inside of, ascending. Neighbours without a crossing between them share a state. So the cost of a traversal
/// depends on what is inside, not on layers x tetrahedra.
class States {
 public:
  static constexpr std::uint32_t kOutside = 0;
  static constexpr std::uint32_t kUnknown = kNoIndex;

  explicit States(std::size_t tets) : of_tet_(tets, kUnknown) {}

  bool is_known(TetId t) const { return of_tet_[t] != kUnknown; }
  std::uint32_t of(TetId t) const { return of_tet_[t]; }
  void set(TetId t, std::uint32_t state) { of_tet_[t] = state; }
  std::span<const Inside> layers(std::uint32_t state) const {
    return {pool_.data() + begin_[state], begin_[state + 1] - begin_[state]};
  }
  std::span<const Inside> at(TetId t) const { return layers(of_tet_[t]); }
  std::uint32_t add(std::span<const Inside> layers) {
    if (layers.empty()) return kOutside;
    pool_.insert(pool_.end(), layers.begin(), layers.end());
    begin_.push_back(pool_.size());
    return static_cast<std::uint32_t>(begin_.size() - 2);
  }

 private:
  std::vector<std::uint32_t> of_tet_;
  std::vector<Inside> pool_;
  std::vector<std::size_t> begin_{0, 0};  // per state: its range in the pool; the first state is empty
};

class WindingTraversal {
 public:
  WindingTraversal(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                   const KnownWinding* some, const Execution& execution)
      : solid_(solid),
        tets_(diagram.dual().tets),
        dual_(diagram.dual()),
        cuts_(cuts),
        some_(some),
        execution_(execution),
        pacer_(execution),
        table_(clip_detail::find_crossings(solid, diagram, cuts, some ? &some->wanted : nullptr, execution)),
        states_(tets_.size()) {
    crossed_.assign(4 * tets_.size(), kNoIndex);
    for (std::uint32_t e = 0; e < table_.edges.size(); ++e) {
      pacer_.step(2);
      const CrossedEdge& edge = table_.edges[e];
      crossed_[4 * static_cast<std::size_t>(edge.tet) + static_cast<std::size_t>(edge.face)] = e;
      const TetId other = tets_[edge.tet].n[edge.face];
      crossed_[4 * static_cast<std::size_t>(other) + back_face(other, edge.tet)] = e;
    }
  }

  Winding run() {
    wind();
    name_inner_vertices();
    emit_intervals();
    return std::move(out_);
  }

 private:
  std::size_t back_face(TetId t, TetId neighbor) const {
    for (std::size_t f = 0; f < 4; ++f)
      if (tets_[t].n[f] == neighbor) return f;
    throw InternalError("adjacency of tetrahedra is not symmetric");
  }
  std::uint32_t crossed(TetId t, int f) const {
    return crossed_[4 * static_cast<std::size_t>(t) + static_cast<std::size_t>(f)];
  }
  bool leads_out_of(const CrossedEdge& edge, TetId t) const { return (edge.tet == t) == edge.forward; }

  bool matters(SiteId s) const { return !some_ || (!dual_.is_corner(s) && some_->wanted[s]); }
  bool tet_matters(TetId t) const {
    const auto& v = tets_[t].v;
    return matters(v[0]) || matters(v[1]) || matters(v[2]) || matters(v[3]);
  }
  /// Whether the Voronoi edge through facet f of t belongs to a cell that matters.
  bool edge_matters(TetId t, int f) const {
    if (!some_) return true;
    const std::array<SiteId, 3> s = outward_facet(tets_[t], f);
    return matters(s[0]) || matters(s[1]) || matters(s[2]);
  }
  std::uint32_t part_at(std::uint32_t crossing) const {
    return solid_.part[cuts_.triangle_cuts[table_.crossings[crossing].cut].triangle];
  }

  // -- w at every Voronoi vertex

  void wind() {
    std::vector<TetId> queue;
    if (some_) start_from_known(queue);
    for (const TetId t : ids<TetId>(tets_.size())) {
      pacer_.step();
      if (!states_.is_known(t) && tet_matters(t) &&
          std::any_of(tets_[t].v.begin(), tets_[t].v.end(), [&](SiteId s) { return dual_.is_corner(s); })) {
        states_.set(t, States::kOutside);
        queue.push_back(t);
      }
    }
    for (std::size_t n = 0; n < queue.size(); ++n) {
      const TetId t = queue[n];
      pacer_.step(4);
      for (int f = 0; f < 4; ++f) {
        const TetId u = tets_[t].n[f];
        if (u == kNoTet || !edge_matters(t, f)) continue;
        const std::uint32_t e = crossed(t, f);
        if (e == kNoIndex) {
          if (!states_.is_known(u)) {
            states_.set(u, states_.of(t));
            queue.push_back(u);
          } else if (states_.of(u) != states_.of(t)) {
            expect_equal(states_.at(t), u);
          }
          continue;
        }
        cross(states_.at(t), table_.edges[e], leads_out_of(table_.edges[e], t));
        if (!states_.is_known(u)) {
          states_.set(u, states_.add(beyond_));
          queue.push_back(u);
        } else {
          expect_equal(beyond_, u);
        }
      }
    }
  }

  void start_from_known(std::vector<TetId>& queue) {
    for (const TetId t : some_->known) {
      pacer_.step();
      if (!tet_matters(t)) continue;
      states_.set(t, States::kOutside);
      queue.push_back(t);
    }
    struct Known {
      TetId tet;
      Inside inside;
    };
    std::vector<Known> known;
    for (const InnerVertex& v : some_->inner_vertices) {
      pacer_.step();
      const TetId t = some_->known[v.tet];
      if (states_.is_known(t)) known.push_back({t, {solid_.parts[v.part].layer, v.winding, v.part}});
    }
    sort_with_polls(execution_, known.begin(), known.end(), [](const Known& x, const Known& y) {
      return x.tet != y.tet ? x.tet < y.tet : x.inside.layer < y.inside.layer;
    });
    for (std::size_t k = 0; k < known.size();) {
      const TetId t = known[k].tet;
      beyond_.clear();
      for (; k < known.size() && known[k].tet == t; ++k) beyond_.push_back(known[k].inside);
      states_.set(t, states_.add(beyond_));
    }
  }

  /// Computes the state beyond the edge's crossings, in beyond_.
  void cross(std::span<const Inside> from, const CrossedEdge& edge, bool out) {
    beyond_.clear();
    const std::span<const LayerCrossings> crossings = table_.layers_of(edge);
    pacer_.step(from.size() + crossings.size());
    std::size_t k = 0;
    for (const LayerCrossings& c : crossings) {
      for (; k < from.size() && from[k].layer < c.layer; ++k) beyond_.push_back(from[k]);
      std::int32_t w = out ? c.jump : -c.jump;
      if (k < from.size() && from[k].layer == c.layer) w += from[k++].winding;
      if (w != 0) beyond_.push_back({c.layer, w, part_at(out ? c.first + c.count - 1 : c.first)});
    }
    beyond_.insert(beyond_.end(), from.begin() + static_cast<std::ptrdiff_t>(k), from.end());
  }

  void expect_equal(std::span<const Inside> expected, TetId u) {
    const std::span<const Inside> found = states_.at(u);
    pacer_.step(found.size());
    const auto same = [](const Inside& x, const Inside& y) {
      return x.layer == y.layer && x.winding == y.winding;
    };
    if (std::equal(expected.begin(), expected.end(), found.begin(), found.end(), same)) return;
    const auto text = [](std::span<const Inside> state) {
      std::string words;
      for (const Inside& i : state)
        words +=
            (words.empty() ? "" : ", ") + std::to_string(i.winding) + " of layer " + std::to_string(i.layer);
      return words.empty() ? std::string("0") : words;
    };
    throw InternalError("two paths give different winding numbers to Voronoi vertex " + std::to_string(u) +
                        ": " + text(found) + " and " + text(expected));
  }

  // -- D vertices, by layer, then by tetrahedron

  void name_inner_vertices() {
    std::vector<std::size_t> next(solid_.layers + 1, 0);
    name_begin_.assign(tets_.size() + 1, 0);
    for (const TetId t : ids<TetId>(tets_.size())) {
      pacer_.step();
      name_begin_[t + 1] = name_begin_[t];
      if (!states_.is_known(t)) continue;
      for (const Inside& i : states_.at(t)) {
        ++next[i.layer + 1];
        ++name_begin_[t + 1];
      }
    }
    const std::size_t count = name_begin_.back();
    if (cuts_.first_d() + count >= 0x80000000u)
      throw Interrupted(
          Error{ErrorCode::kTooComplex, "The cuts have more than 2^31 vertices. Ask for fewer sites."});
    for (std::uint32_t l = 0; l < solid_.layers; ++l) next[l + 1] += next[l];
    resize_with_polls(execution_, names_, count);
    resize_with_polls(execution_, out_.inner_vertices, count);
    for (const TetId t : ids<TetId>(tets_.size())) {
      pacer_.step();
      if (!states_.is_known(t)) continue;
      CutVertexId* name = names_.data() + name_begin_[t];
      for (const Inside& i : states_.at(t)) {
        const std::size_t n = next[i.layer]++;
        out_.inner_vertices[n] = {t, i.part, i.winding};
        *name++ = CutVertexId{cuts_.first_d() + n};
      }
    }
  }

  // -- the intervals with w != 0

  void emit_intervals() {
    constexpr std::size_t kTetsPerBlock = 256;
    std::vector<std::vector<CapSegment>> found((tets_.size() + kTetsPerBlock - 1) / kTetsPerBlock);
    parallel_for(execution_, tets_.size(), kTetsPerBlock, [&](std::size_t begin, std::size_t end) {
      Pacer pacer(execution_);
      std::size_t counted = 0;
      std::vector<CapSegment>& segments = found[begin / kTetsPerBlock];
      for (const TetId t : ids<TetId>(begin, end)) {
        if (!states_.is_known(t)) continue;
        const std::size_t before = segments.size();
        for (int f = 0; f < 4; ++f) emit_edge(t, f, segments);
        pacer.step(2 + segments.size() - before);
        if (segments.size() - counted < kCountedTogether) continue;
        execution_.made(Product::kSegments, segments.size() - counted);
        counted = segments.size();
      }
      execution_.made(Product::kSegments, segments.size() - counted);
    });
    join(found);
  }

  // Ordered by layer, whose parts are disjoint; within a layer, by tetrahedron.
  void join(const std::vector<std::vector<CapSegment>>& found) {
    const auto layer_of = [&](const CapSegment& s) { return solid_.parts[s.part].layer; };
    std::vector<std::size_t> next(solid_.layers + 1, 0);
    for (const auto& segments : found) {
      pacer_.step(segments.size());
      for (const CapSegment& s : segments) ++next[layer_of(s) + 1];
    }
    for (std::uint32_t l = 0; l < solid_.layers; ++l) next[l + 1] += next[l];
    resize_with_polls(execution_, out_.segments, next.back());
    for (const auto& segments : found) {
      pacer_.step(segments.size());
      for (const CapSegment& s : segments) out_.segments[next[layer_of(s)]++] = s;
    }
  }

  /// Emits the intervals of all layers on the Voronoi edge through facet f of t, from its lower end.
  void emit_edge(TetId t, int f, std::vector<CapSegment>& out) const {
    const TetId u = tets_[t].n[f];
    if (u == kNoTet || u < t || !edge_matters(t, f)) return;
    if (!states_.is_known(u)) throw InternalError("Voronoi vertex " + std::to_string(u) + " was not reached");
    const std::span<const Inside> here = states_.at(t), there = states_.at(u);
    const CutVertexId *name_here = names_.data() + name_begin_[t],
                      *name_there = names_.data() + name_begin_[u];
    const std::uint32_t e = crossed(t, f);
    if (e == kNoIndex) {
      for (std::size_t k = 0; k < here.size(); ++k)
        emit(t, f, name_here[k], name_there[k], here[k].winding, here[k].part, out);
      return;
    }
    const CrossedEdge& edge = table_.edges[e];
    const bool forward = leads_out_of(edge, t);
    std::size_t k = 0, m = 0;
    const auto pass_until = [&](std::uint32_t layer) {
      for (; k < here.size() && here[k].layer < layer; ++k, ++m)
        emit(t, f, name_here[k], name_there[m], here[k].winding, here[k].part, out);
    };
    for (const LayerCrossings& layer : table_.layers_of(edge)) {
      pass_until(layer.layer);
      // From t's Voronoi vertex to that of u, crossing by crossing.
      CutVertexId from{kNoIndex};
      std::int32_t w = 0;
      if (k < here.size() && here[k].layer == layer.layer) {
        from = name_here[k];
        w = here[k++].winding;
      }
      for (std::uint32_t n = 0; n < layer.count; ++n) {
        const std::uint32_t c = forward ? layer.first + n : layer.first + layer.count - 1 - n;
        const Crossing& crossing = table_.crossings[c];
        const CutVertexId to{cuts_.first_c() + crossing.cut};
        if (w != 0) emit(t, f, from, to, w, part_at(c), out);
        w += forward ? crossing.step : -crossing.step;
        from = to;
      }
      if (w != 0) {
        emit(t, f, from, name_there[m], w, there[m].part, out);
        ++m;
      }
    }
    pass_until(kNoIndex);
  }

  // An interval directed out of tetrahedron t through facet f = (a, b, c), counter-clockwise about that
  // direction, is a positive boundary piece of the Voronoi facets (a, b), (b, c), (c, a). Each is seen with
  // its normal from first to second:
  //
  //            a                    the Voronoi edge points at the reader; facet (a, b) extends to the left,
  //      (a,b) | (c,a)              its normal n leads from a to b, and n x (edge direction) points into it:
  //           \ /                   the interior lies on the left of the edge seen from the tip of n
  //        b --+-- c
  //          (b,c)
  void emit(TetId t, int f, CutVertexId from, CutVertexId to, std::int32_t w, std::uint32_t part,
            std::vector<CapSegment>& out) const {
    const std::array<SiteId, 3> s = outward_facet(tets_[t], f);
    for (int k = 0; k < 3; ++k) {
      const SiteId a = s[k], b = s[(k + 1) % 3];
      if (!matters(a) && !matters(b)) continue;
      if (a < b)
        out.push_back({a, b, from, to, w, part});
      else
        out.push_back({b, a, to, from, w, part});
    }
  }

  static constexpr std::size_t kCountedTogether = 4096;

  const Solid& solid_;
  const std::vector<Tetrahedron>& tets_;
  const Tetrahedralization& dual_;
  const SurfaceCuts& cuts_;
  const KnownWinding* const some_;
  const Execution& execution_;
  Pacer pacer_;
  const CrossingTable table_;
  std::vector<std::uint32_t> crossed_;  // per facet of each tetrahedron: index of its CrossedEdge
  States states_;
  std::vector<Inside> beyond_;
  // Per tetrahedron: its range in names_, with one name per layer of its state
  std::vector<std::size_t> name_begin_;
  std::vector<CutVertexId> names_;
  Winding out_;
};

}  // namespace

Winding wind_voronoi_edges(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                           const Execution& execution) {
  return WindingTraversal(solid, diagram, cuts, nullptr, execution).run();
}

Winding wind_voronoi_edges_of(const Solid& solid, const VoronoiDiagram& diagram, const SurfaceCuts& cuts,
                              const KnownWinding& known, const Execution& execution) {
  return WindingTraversal(solid, diagram, cuts, &known, execution).run();
}

}  // namespace fracture
