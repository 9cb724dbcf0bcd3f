// Shared by the translation units of IncrementalDelaunay and of the reference: the steps around an insertion,
// and the inlined filter of in_sphere.
#pragma once

#include <cmath>

#include "common/delaunay/incremental.hpp"

namespace fracture {

template <class Fill>
IncrementalDelaunay::Insertion IncrementalDelaunay::insert_with(const Vec3d& p, const Fill& fill) {
  if (!big_.contains(p)) return {Status::kOutsideDomain, kNoVertex};
  const Located at = locate(p, last_);
  for (const TetVertexId v : tets_[at.tet].v)
    if (position(v) == p) return {Status::kDuplicate, v};
  if (tet_count() > options_.max_tets) return {Status::kFull, kNoVertex};
  const TetVertexId v = new_vertex(p);
  fill(v, at);
  last_ = vertices_[v].tet;
  return {Status::kInserted, v};
}

[[gnu::always_inline]] inline IncrementalDelaunay::Filtered IncrementalDelaunay::filter(const Tet& t,
                                                                                        const Query& q) {
  const Vec3d d = q.normalized - Vec3d{t.center[0], t.center[1], t.center[2]};
  const double radius2 = static_cast<double>(t.radius2), beyond = dot(d, d) - radius2;
  // These comparisons make NaN uncertain.
  return {beyond<0, std::fabs(beyond)> delaunay_detail::kMargin * radius2};
}

inline bool IncrementalDelaunay::in_conflict(const Tet& t, const Query& q) const {
  const auto [inside, certain] = filter(t, q);
  return certain ? inside : in_conflict_exact(t, q.p);
}

}  // namespace fracture
