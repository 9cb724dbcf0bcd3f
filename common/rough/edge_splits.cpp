#include "common/rough/edge_splits.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// Tolerance, in parts, for the number of parts: a piece that is only this much too long gets no extra part.
constexpr double kSlack = 1e-6;

struct Ends {
  CutVertexId low, high;
};
template <class Edge>
Ends ends_of(const Edge& e) {
  return {std::min(e.from, e.to), std::max(e.from, e.to)};
}
bool operator<(const Ends& x, const Ends& y) { return x.low != y.low ? x.low < y.low : x.high < y.high; }
bool operator==(const Ends& x, const Ends& y) { return x.low == y.low && x.high == y.high; }

}  // namespace

std::array<std::int32_t, 3> nearest_steps(const SeamLattice& lattice, const Vec3d& p) {
  const Vec3d step = lattice.step();
  std::array<std::int32_t, 3> steps{};
  for (int a = 0; a < 3; ++a)
    steps[static_cast<std::size_t>(a)] = static_cast<std::int32_t>(std::nearbyint(p[a] / step[a]));
  return steps;
}

CutVertexId append_vertex(VertexPositions& positions, const Vec3d& p) {
  positions.points.push_back(p);
  positions.steps.push_back(nearest_steps(positions.lattice, p));
  return CutVertexId{positions.first_constructed + positions.points.size() - 1};
}

EdgeSplits::EdgeSplits(const Winding& winding, double length,
                       const std::function<bool(SiteId, SiteId)>& wanted,
                       const std::function<bool(SiteId, SiteId)>& plain, VertexPositions& positions,
                       const Execution& execution) {
  Pacer pacer(execution);
  // Positions rounded to the seam lattice, which are equal for coinciding vertices.
  const auto at = [&](CutVertexId v) {
    return positions.lattice.to_world(positions.steps[v - positions.first_constructed]);
  };
  for (const CapSegment& s : winding.segments) {
    pacer.step();
    if (s.from == s.to || !wanted(s.lo, s.hi)) continue;
    const bool forwards = !lexicographic_less(at(s.to), at(s.from));
    edges_.push_back({forwards ? s.from : s.to, forwards ? s.to : s.from, CutVertexId{0}, 0});
  }
  sort_with_polls(execution, edges_.begin(), edges_.end(),
                  [](const Edge& x, const Edge& y) { return ends_of(x) < ends_of(y); });
  edges_.erase(std::unique(edges_.begin(), edges_.end(),
                           [](const Edge& x, const Edge& y) { return ends_of(x) == ends_of(y); }),
               edges_.end());
  std::vector<Ends> whole;
  for (const CapSegment& s : winding.segments) {
    pacer.step();
    if (plain(s.lo, s.hi)) whole.push_back(ends_of(s));
  }
  sort_with_polls(execution, whole.begin(), whole.end());
  std::erase_if(edges_,
                [&](const Edge& e) { return std::binary_search(whole.begin(), whole.end(), ends_of(e)); });
  for (Edge& e : edges_) {
    pacer.step();
    const Vec3d a = at(e.from), along = at(e.to) - a;
    const double parts = std::ceil(fracture::length(along) / length - kSlack);
    e.count = parts > 1 ? static_cast<std::uint32_t>(parts) - 1 : 0;
    e.first = CutVertexId{positions.first_constructed + positions.points.size()};
    execution.made(Product::kSegments, e.count);
    for (std::uint32_t k = 1; k <= e.count; ++k)
      append_vertex(positions, a + (static_cast<double>(k) / (e.count + 1)) * along);
  }
  std::erase_if(edges_, [](const Edge& e) { return e.count == 0; });
}

const EdgeSplits::Edge* EdgeSplits::find(CutVertexId a, CutVertexId b) const {
  const Edge key{a, b, CutVertexId{0}, 0};
  const auto it = std::lower_bound(edges_.begin(), edges_.end(), key,
                                   [](const Edge& x, const Edge& y) { return ends_of(x) < ends_of(y); });
  return it != edges_.end() && ends_of(*it) == ends_of(key) ? &*it : nullptr;
}

void EdgeSplits::between(CutVertexId a, CutVertexId b, std::vector<CutVertexId>& out) const {
  const Edge* e = find(a, b);
  if (!e) return;
  for (std::uint32_t k = 0; k < e->count; ++k)
    out.push_back(CutVertexId{e->first + (e->from == a ? k : e->count - 1 - k)});
}

}  // namespace fracture
