#include "common/pipeline/cell_patch.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/exact/side.hpp"

namespace fracture {
namespace {

std::vector<Box> boxes_of_triangles(const Solid& solid, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Box> boxes(solid.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (const VertexId v : solid.triangles[t]) boxes[t].add(to_double(solid.positions[v]));
    pacer.step();
  }
  return boxes;
}

/// Signs that a bisector's value, seen from site i, can have within a box.
struct Range {
  bool below, above;  ///< whether the value may be negative, and whether it may be positive
};
Range range_over(const VoronoiDiagram& diagram, SiteId i, const Bisector& b, const Box& box) {
  Vec3d low, high;  // the corners with the least and the largest value
  for (int a = 0; a < 3; ++a) {
    low[a] = b.u[a] > 0 ? box.max[a] : box.min[a];
    high[a] = b.u[a] > 0 ? box.min[a] : box.max[a];
  }
  return {diagram.value(i, b, low) <= b.error, diagram.value(i, b, high) >= -b.error};
}

/// Returns the triangles that no bisector of the cell certainly excludes, in any order.
std::vector<std::uint32_t> near_triangles(const BoxTree& tree, const VoronoiDiagram& diagram, SiteId cell,
                                          Pacer& pacer) {
  const std::span<const Bisector> bisectors = diagram.bisectors(cell);
  // On the way down the tree: for each box entered, the bisectors that may run through it. A bisector that
  // has the whole box on the cell's side need not be tested within it.
  std::vector<std::uint32_t> running(bisectors.size());
  for (std::uint32_t k = 0; k < running.size(); ++k) running[k] = k;
  std::vector<std::size_t> begin{0};
  std::vector<std::uint32_t> found;
  tree.each_entered(
      [&](const Box& box) {
        const std::size_t first = begin.back(), last = running.size();
        pacer.step(1 + last - first);
        for (std::size_t k = first; k < last; ++k) {
          const Range range = range_over(diagram, cell, bisectors[running[k]], box);
          if (!range.above) {
            running.resize(last);
            return false;
          }
          if (range.below) running.push_back(running[k]);
        }
        begin.push_back(last);
        return true;
      },
      [&] {
        running.resize(begin.back());
        begin.pop_back();
      },
      [&](std::uint32_t t) { found.push_back(t); });
  return found;
}

const Bisector& bisector_between(const VoronoiDiagram& diagram, SiteId i, SiteId j) {
  const std::span<const Bisector> all = diagram.bisectors(i);
  const auto at = std::lower_bound(all.begin(), all.end(), j,
                                   [](const Bisector& b, SiteId site) { return b.neighbor < site; });
  if (at == all.end() || at->neighbor != j)
    throw InternalError("sites " + std::to_string(i) + " and " + std::to_string(j) + " are not neighbours");
  return *at;
}

/// A facet of a tetrahedron. Its dual Voronoi edge leads from the tetrahedron's Voronoi vertex to that of
/// the neighbour.
struct Step {
  TetId from;
  int face;
};

/// Returns a shortest path from a Voronoi vertex of the cell to one beyond the box, last step first. The
/// path is empty if one of the cell's own vertices is beyond the box.
std::vector<Step> way_out(const VoronoiDiagram& diagram, SiteId cell, Pacer& pacer) {
  const Tetrahedralization& dual = diagram.dual();
  const auto beyond = [&](TetId t) {
    const auto& v = dual.tets[t].v;
    return std::any_of(v.begin(), v.end(), [&](SiteId s) { return dual.is_corner(s); });
  };
  constexpr int kUnseen = -1, kStart = -2;
  std::vector<int> entered(dual.tets.size(), kUnseen);  // its own facet through which it was entered
  std::vector<TetId> queue;
  for (const TetId t : diagram.tetrahedra(cell)) {
    if (beyond(t)) return {};
    entered[t] = kStart;
    queue.push_back(t);
  }
  const auto facet_to = [&](TetId t, TetId neighbor) {
    const auto& n = dual.tets[t].n;
    return static_cast<int>(std::find(n.begin(), n.end(), neighbor) - n.begin());
  };
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const TetId t = queue[k];
    pacer.step(4);
    for (int f = 0; f < 4; ++f) {
      const TetId u = dual.tets[t].n[f];
      if (u == kNoTet || entered[u] != kUnseen) continue;
      entered[u] = facet_to(u, t);
      queue.push_back(u);
      if (!beyond(u)) continue;
      std::vector<Step> way;
      for (TetId at = u; entered[at] != kStart;) {
        const TetId before = dual.tets[at].n[entered[at]];
        way.push_back({before, facet_to(before, at)});
        at = before;
      }
      return way;
    }
  }
  throw InternalError("no way leads out of the tetrahedra around site " + std::to_string(cell));
}

/// The Voronoi edge of one step, and the triangles that cross it.
class CrossedEdge {
 public:
  CrossedEdge(const VoronoiDiagram& diagram, const Step& step) : diagram_(diagram) {
    const Tetrahedron& t = diagram.dual().tets[step.from];
    const Tetrahedron& u = diagram.dual().tets[t.n[step.face]];
    // The facet's sites, counter-clockwise as seen from outside the tetrahedron. The edge's direction out
    // of it is (b - a) x (c - a).
    sites_ = outward_facet(t, step.face);
    ends_[0] = t.v[step.face];
    for (const SiteId s : u.v)
      if (std::find(sites_.begin(), sites_.end(), s) == sites_.end()) ends_[1] = s;
    const SiteId i = sites_[0];
    planes_ = {&bisector_between(diagram, i, sites_[1]), &bisector_between(diagram, i, sites_[2])};
    limits_ = {&bisector_between(diagram, i, ends_[0]), &bisector_between(diagram, i, ends_[1])};
  }

  bool may_meet(const Box& box) const {
    for (const Bisector* b : planes_)
      if (const Range r = range_over(diagram_, sites_[0], *b, box); !r.below || !r.above) return false;
    for (const Bisector* b : limits_)
      if (!range_over(diagram_, sites_[0], *b, box).above) return false;
    return true;
  }

  /// Returns how the edge, in the direction of the step, passes through the triangle: 1 outwards, -1
  /// inwards, 0 not at all.
  int crossing(const std::array<Vec3d, 3>& p) const {
    const Vec3d &i = diagram_.site(sites_[0]), &j = diagram_.site(sites_[1]), &k = diagram_.site(sites_[2]);
    // The bisector of i and j divides two of the triangle's sides, at two points. The edge lies in that
    // bisector. It passes through the triangle if the bisector of i and k separates these two points.
    std::array<int, 3> side;
    for (int c = 0; c < 3; ++c) side[c] = exact::side1(i, j, p[c]);
    int places = 0, sum = 0;
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3;
      if (side[c] == side[d]) continue;
      ++places;
      sum += exact::side2(i, k, p[c], p[d], j);
    }
    if (places == 0 || sum != 0) return 0;
    for (const SiteId end : ends_)
      if (exact::side3(i, diagram_.site(end), p[0], p[1], p[2], j, k) < 0) return 0;
    return exact::crossing_sign(p[0], p[1], p[2], i, j, k);
  }

 private:
  const VoronoiDiagram& diagram_;
  std::array<SiteId, 3> sites_;
  std::array<SiteId, 2> ends_{};  // together with sites_, these form the two Voronoi vertices
  std::array<const Bisector*, 2> planes_, limits_;
};

}  // namespace

PatchFinder::PatchFinder(const Solid& solid, const Execution& execution)
    : solid_(solid), tree_(boxes_of_triangles(solid, execution), execution) {}

CellPatch PatchFinder::around(const VoronoiDiagram& diagram, SiteId cell, const Execution& execution) const {
  Pacer pacer(execution);
  CellPatch patch;
  std::vector<std::uint32_t> triangles = near_triangles(tree_, diagram, cell, pacer);
  sort_with_polls(execution, triangles.begin(), triangles.end());
  patch.looked_at = triangles.size();

  // Windings of the parts around a Voronoi vertex of the cell. Each part is closed, so its crossings alone
  // determine its winding.
  std::vector<std::pair<std::uint32_t, std::int32_t>> windings;  // part, crossing
  const std::vector<Step> way = way_out(diagram, cell, pacer);
  if (!way.empty()) patch.seed = {way.back().from};
  for (const Step& step : way) {
    const CrossedEdge edge(diagram, step);
    tree_.each_entered(
        [&](const Box& box) {
          pacer.step();
          return edge.may_meet(box);
        },
        [] {},
        [&](std::uint32_t t) {
          ++patch.looked_at;
          const auto& v = solid_.triangles[t];
          const int crossing =
              edge.crossing({to_double(solid_.positions[v[0]]), to_double(solid_.positions[v[1]]),
                             to_double(solid_.positions[v[2]])});
          if (crossing != 0) windings.emplace_back(solid_.part[t], crossing);
        });
  }
  std::sort(windings.begin(), windings.end());
  std::size_t kept = 0;
  for (std::size_t k = 0; k < windings.size();) {
    auto [part, winding] = windings[k++];
    for (; k < windings.size() && windings[k].first == part; ++k) winding += windings[k].second;
    if (winding != 0) windings[kept++] = {part, winding};
  }
  windings.resize(kept);

  std::vector<std::uint32_t> parts_around;
  for (const auto& [part, winding] : windings) parts_around.push_back(part);
  patch.surface = patch_of(solid_, std::move(triangles), parts_around, execution);
  for (const auto& [part, winding] : windings)
    patch.seed_winding.push_back({TetId{0}, patch.surface.local_part(part), winding});
  return patch;
}

}  // namespace fracture
