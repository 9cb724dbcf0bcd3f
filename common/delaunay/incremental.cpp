#include "common/delaunay/incremental.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/base/pacer.hpp"
#include "common/delaunay/incremental_detail.hpp"
#include "common/exact/in_sphere.hpp"

namespace fracture {
namespace {

double orient_bound(const BigTetrahedron& big) {
  // Any difference of two points in the big tetrahedron is at most as long as its edge, 2 sqrt(2) K.
  const double edge = 2.8285 * big.half;
  return exact::kOrient3dError * edge * edge * edge + exact::kUnderflow;
}

}  // namespace

IncrementalDelaunay::IncrementalDelaunay(const BigTetrahedron& big, Options options)
    : big_(big), options_(options), orient_bound_(orient_bound(big)), inverse_half_(1 / big.half) {
  const std::array<Vec3d, 4> corners = big.corners();
  for (const Vec3d& c : corners) new_vertex(c);
  make_tet(TetVertexId{0}, TetVertexId{1}, TetVertexId{2}, TetVertexId{3});
}

IncrementalDelaunay::IncrementalDelaunay(const BigTetrahedron& big, Options options,
                                         const Tetrahedralization& finished)
    : big_(big), options_(options), orient_bound_(orient_bound(big)), inverse_half_(1 / big.half) {
  const std::uint32_t sites = finished.site_count();
  vertices_.reserve(finished.points.size());
  for (std::uint32_t k = 0; k < 4; ++k) new_vertex(finished.points[sites + k]);
  for (const SiteId s : ids<SiteId>(sites)) new_vertex(finished.points[s]);
  const auto vertex = [sites](SiteId s) { return TetVertexId{s < sites ? s + 4 : s - sites}; };
  tets_.resize(finished.tets.size());
  Pacer pacer(*options_.execution);
  for (const TetId t : ids<TetId>(tets_.size())) {
    pacer.step(4);
    const Tetrahedron& from = finished.tets[t];
    Tet& tet = tets_[t];
    tet = Tet{{vertex(from.v[0]), vertex(from.v[1]), vertex(from.v[2]), vertex(from.v[3])},
              {kNoLink, kNoLink, kNoLink, kNoLink},
              {},
              0,
              0};
    for (int k = 0; k < 4; ++k) {
      if (from.n[k] == kNoTet) continue;
      const auto& back = finished.tets[from.n[k]].n;
      tet.n[k] =
          Link(from.n[k], static_cast<unsigned>(std::find(back.begin(), back.end(), t) - back.begin()));
    }
    set_sphere(tet);
    for (const TetVertexId v : tet.v) vertices_[v].tet = t;
  }
}

void IncrementalDelaunay::reserve(std::size_t sites) {
  vertices_.reserve(sites + 4);
  tets_.reserve(reserved_tets(sites));
  if (!reserves_much(sites)) return;
  constexpr std::size_t kAtOnce = std::size_t{1} << 24;  // bytes; takes a few milliseconds
  const std::size_t bytes = tets_.capacity() * sizeof(Tet);
  auto* const memory = reinterpret_cast<std::byte*>(tets_.data());
  for (std::size_t at = 0; at < bytes; at += kAtOnce) {
    options_.execution->poll();
    populate_pages(memory + at, std::min(kAtOnce, bytes - at));
  }
}

TetVertexId IncrementalDelaunay::new_vertex(const Vec3d& p) {
  scale_.include(p);
  // + 0.0 makes negative zeros positive, so that equal points have equal bits.
  const Vertex vertex{p.x + 0.0, p.y + 0.0, p.z + 0.0, TetId{0}, kNoLocal};
  if (free_vertices_.empty()) {
    vertices_.push_back(vertex);
    return TetVertexId{vertices_.size() - 1};
  }
  const TetVertexId v = free_vertices_.back();
  free_vertices_.pop_back();
  vertices_[v] = vertex;
  return v;
}

TetId IncrementalDelaunay::new_tet() {
  if (!free_tets_.empty()) {
    const TetId t = free_tets_.back();
    free_tets_.pop_back();
    return t;
  }
  tets_.emplace_back();
  return TetId{tets_.size() - 1};
}

void IncrementalDelaunay::free_tet(TetId t) {
  tets_[t].v[0] = kNoVertex;
  tets_[t].mark = 0;
  free_tets_.push_back(t);
}

TetId IncrementalDelaunay::make_tet(TetVertexId a, TetVertexId b, TetVertexId c, TetVertexId d) {
  const TetId t = new_tet();
  tets_[t] = Tet{{a, b, c, d}, {kNoLink, kNoLink, kNoLink, kNoLink}, {}, 0, 0};
  set_sphere(tets_[t]);
  for (const TetVertexId v : tets_[t].v) vertices_[v].tet = t;
  return t;
}

void IncrementalDelaunay::set_sphere(Tet& t) const {
  const Vec3d o = position(t.v[0]);
  const auto edge = [&](TetVertexId v) {
    const Vec3d to = position(v) - o;
    return delaunay_detail::Edge<double>{{to.x, to.y, to.z}, dot(to, to)};
  };
  const auto [center, radius2] = delaunay_detail::circumsphere<double>(
      normalized(o), inverse_half_, edge(t.v[1]), edge(t.v[2]), edge(t.v[3]));
  t.center[0] = center.x;
  t.center[1] = center.y;
  t.center[2] = center.z;
  t.radius2 = static_cast<float>(radius2);
}

void IncrementalDelaunay::next_visit() {
  visit_ += 2;
  if (visit_ >= 0xfffffff0u) {
    for (Tet& t : tets_) t.mark = 0;
    visit_ = 2;
  }
}

bool IncrementalDelaunay::in_conflict_exact(const Tet& t, const Vec3d& p) const {
  return exact::in_sphere(position(t.v[0]), position(t.v[1]), position(t.v[2]), position(t.v[3]), p, scale_,
                          &counters_.in_sphere) > 0;
}

// Remembering stochastic walk (Devillers, Pion & Teillaud 2001; the paper's Algorithm 2). Goes through any facet
// that separates the tetrahedron from p, trying facets from a random one on, but never back through the facet
// it came from. The random choice makes the walk terminate in every triangulation. Its generator is part of
// the state, so runs are reproducible.
std::optional<IncrementalDelaunay::Located> IncrementalDelaunay::walk(const Vec3d& p, TetId t) {
  unsigned came = 4;
  for (std::uint64_t steps = 1;; ++steps) {
    const Tet& tet = tets_[t];
    Vec3d q[4];
    for (int k = 0; k < 4; ++k) q[k] = position(tet.v[k]) - p;
    walk_state_ = walk_state_ * 6364136223846793005ull + 1442695040888963407ull;
    const unsigned first = walk_state_ >> 62;
    // Which facets separate is unpredictable, so all are tested without branches.
    unsigned beyond = 0, doubtful = 0, zeros = 0, left_by = 4;
    for (unsigned k = 0; k < 4; ++k) {
      const std::uint8_t* f = kFacet[k];
      const double det = exact::det3(q[f[0]], q[f[1]], q[f[2]]);
      beyond |= static_cast<unsigned>(det < -orient_bound_) << k;
      doubtful |= static_cast<unsigned>(!(std::fabs(det) > orient_bound_)) << k;
    }
    const unsigned others = ~(1u << came) & 15;
    beyond &= others;
    if (doubtful & others) [[unlikely]] {
      for (unsigned i = 0; i < 4 && left_by == 4; ++i) {
        const unsigned k = (first + i) & 3;
        if (!(others >> k & 1)) continue;
        int side = beyond >> k & 1 ? -1 : 1;
        if (doubtful >> k & 1)
          side = orient3d(p, position(tet.v[kFacet[k][0]]), position(tet.v[kFacet[k][1]]),
                          position(tet.v[kFacet[k][2]]));
        if (side < 0) left_by = k;
        if (side == 0) zeros |= 1u << k;
      }
    } else if (beyond) {
      left_by = (first + static_cast<unsigned>(std::countr_zero(beyond * 17 >> first))) & 3;
    }
    if (left_by == 4) {
      counters_.walk_steps += steps;
      return Located{t, zeros};
    }
    const Link link = tet.n[left_by];
    if (link == kNoLink) return std::nullopt;
    t = link.tet();
    came = link.facet();
  }
}

IncrementalDelaunay::Located IncrementalDelaunay::locate(const Vec3d& p, TetId start) {
  if (const std::optional<Located> at = walk(p, start)) return *at;
  throw InternalError("walk left the big tetrahedron: a site outside the domain");
}

}  // namespace fracture
