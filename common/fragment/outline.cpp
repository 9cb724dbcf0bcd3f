#include "common/fragment/outline.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/pacer.hpp"

namespace fracture {

void Outline::triangulate_into(std::uint32_t t, std::vector<Face>& out) {
  sort_with_polls(execution_, sides_.begin(), sides_.end(),
                  [](const Side& a, const Side& b) { return a.from < b.from; });
  Pacer pacer(execution_);
  loop_.clear();
  loop_begin_.assign(1, 0);
  for (std::size_t start = 0; start < sides_.size(); ++start) {
    if (sides_[start].used) continue;
    ring_.clear();
    for (std::size_t s = start; !sides_[s].used; s = leaving(sides_[s].to, t)) {
      sides_[s].used = true;
      ring_.push_back(sides_[s].from);
      pacer.step();
    }
    const std::size_t n = ring_.size(), loop_start = loop_.size();
    for (std::size_t k = 0; k < n; ++k)
      if (!is_straight(ring_[(k + n - 1) % n], ring_[k], ring_[(k + 1) % n])) loop_.push_back(ring_[k]);
    if (loop_.size() > loop_start) loop_begin_.push_back(static_cast<std::uint32_t>(loop_.size()));
  }
  const std::array<CutVertexId, 3> corners = d_.corners(t);
  const auto is_corner = [&](CutVertexId v) {
    return std::find(corners.begin(), corners.end(), v) != corners.end();
  };
  if (loop_.size() == 3 && std::all_of(loop_.begin(), loop_.end(), is_corner)) {
    out.push_back({corners, t});
    return;
  }
  const bool mirrored = mirrored_.is_mirrored(t), reversed = mirrored && mirrored_.is_reversed(t);
  if (mirrored) arrange_loops(reversed);
  project(t, reversed);
  triangulate(points_, loop_begin_, triangulation_, execution_);
  for (const auto& k : triangulation_.triangles)
    out.push_back({{loop_[k[0]], loop_[k[reversed ? 2 : 1]], loop_[k[reversed ? 1 : 2]]}, t});
}

std::size_t Outline::leaving(CutVertexId v, std::uint32_t t) const {
  const auto it = std::lower_bound(sides_.begin(), sides_.end(), v,
                                   [](const Side& s, CutVertexId key) { return s.from < key; });
  if (it == sides_.end() || it->from != v)
    throw InternalError("the fused polygon of triangle " + std::to_string(t) + " is open at vertex " +
                        std::to_string(v));
  return static_cast<std::size_t>(it - sides_.begin());
}

bool Outline::lies_on(CutVertexId v, std::uint32_t edge) const {
  if (v < d_.cuts.first_b()) {
    const auto& ends = d_.solid.edge_vertices[edge];
    return v == cut_vertex(ends[0]) || v == cut_vertex(ends[1]);
  }
  return v < d_.cuts.first_c() && d_.cuts.edge_cuts[v - d_.cuts.first_b()].edge == edge;
}

bool Outline::is_straight(CutVertexId before, CutVertexId v, CutVertexId after) const {
  if (v < d_.cuts.first_b() || v >= d_.cuts.first_c()) return false;  // only edge cuts lie within an edge
  const std::uint32_t edge = d_.cuts.edge_cuts[v - d_.cuts.first_b()].edge;
  return lies_on(before, edge) && lies_on(after, edge);
}

// Gives the loops an order that is the same in the mirror image of the triangle.
void Outline::arrange_loops(bool reversed) {
  std::vector<MirroredRings::Ring> loops;
  for (std::size_t k = 0; k + 1 < loop_begin_.size(); ++k) {
    loops.emplace_back(loop_.begin() + loop_begin_[k], loop_.begin() + loop_begin_[k + 1]);
    mirrored_.arrange(loops.back(), reversed);
  }
  mirrored_.sort(loops);
  loop_.clear();
  loop_begin_.assign(1, 0);
  for (const MirroredRings::Ring& loop : loops) {
    loop_.insert(loop_.end(), loop.begin(), loop.end());
    loop_begin_.push_back(static_cast<std::uint32_t>(loop_.size()));
  }
}

// Projects onto the lattice and drops the axis of the largest normal component. The choice of triangulation
// may depend on rounded positions; closedness does not.
void Outline::project(std::uint32_t t, bool reversed) {
  const auto& v = d_.solid.triangles[t];
  const Vec3d a = to_double(d_.solid.positions[v[0]]), b = to_double(d_.solid.positions[v[1]]),
              c = to_double(d_.solid.positions[v[2]]);
  const Vec3d n = cross(b - a, c - a);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(n[k]) > std::fabs(n[axis])) axis = k;
  int x = (axis + 1) % 3, y = (axis + 2) % 3;
  if ((n[axis] < 0) != reversed) std::swap(x, y);
  const Vec3d step = d_.positions.lattice.step();
  points_.clear();
  for (const CutVertexId id : loop_) {
    const Vec3d p = mirrored_.is_mirrored(t) ? mirrored_.place(id) : d_.point(id);
    points_.push_back({static_cast<std::int64_t>(std::nearbyint(p[x] / step[x])),
                       static_cast<std::int64_t>(std::nearbyint(p[y] / step[y]))});
  }
}

}  // namespace fracture
