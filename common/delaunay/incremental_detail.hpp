// Shared by the translation units of IncrementalDelaunay and of the reference: what surrounds an insertion,
// and the inlined in_sphere filter.
#pragma once

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

/// The sphere filter. With u = 2^-53: the error of |d|^2 - axis·d is at most
///   6u |d|^2                        (each difference 1 rounding, squares 3, sums 5, last subtraction 6)
/// + (error + 6u max|axis|) |d|_1    (axis itself, and the same roundings of the dot product)
/// where set_sphere() has put the second term's 6u max|axis| into `error` already. 1e-300 covers underflow.
[[gnu::always_inline]] inline bool IncrementalDelaunay::in_conflict(const Tet& t, const Vec3d& p) const {
  const Vertex& o = vertices_[t.v[0]];
  const double dx = p.x - o.x, dy = p.y - o.y, dz = p.z - o.z;
  const double d2 = dx * dx + dy * dy + dz * dz;
  const double g = d2 - (t.axis[0] * dx + t.axis[1] * dy + t.axis[2] * dz);
  const double bound =
      static_cast<double>(t.error) * (std::fabs(dx) + std::fabs(dy) + std::fabs(dz)) + 0x1p-50 * d2 + 1e-300;
  if (!(std::fabs(g) > bound)) [[unlikely]]  // also when the bound is infinite
    return in_conflict_exact(t, p);
  return g < 0;
}

/// b, c, d: the vertices 1..3 relative to vertex 0, each with one rounding; lifts their squared lengths.
///   axis = n / delta,  n = |b|^2 (c x d) + |c|^2 (d x b) + |d|^2 (b x c),  delta = b · (c x d)
/// With r the longest of b, c, d and u = 2^-53: each component of n has error at most E_n = gamma_12 * 3 r^4
/// <= 40u r^4, delta at most E_d = 16u r^3 (orient3d.hpp). If |delta| > 2 E_d then
///   |n~/delta~ - n/delta| <= (E_n + |axis| E_d) / (|delta~| - E_d)
///                         <= 2 (40u r^4 + 16u r^3 |axis|) / |delta~|
/// and the division and the dot product of the filter add 2u + 6u times |axis|; all constants are rounded up,
/// and so is the float.
inline void IncrementalDelaunay::set_sphere(Tet& t, const Vec3d& b, const Vec3d& c, const Vec3d& d,
                                            double lift_b, double lift_c, double lift_d) {
  using exact::larger;
  constexpr double u = 0x1p-53;
  const Vec3d cd = cross(c, d), db = cross(d, b), bc = cross(b, c);
  const double delta = dot(b, cd);
  const double r2 = larger(lift_b, larger(lift_c, lift_d));
  const double r3 = r2 * std::sqrt(r2);
  const double inverse = 1 / delta;
  const double ax = (lift_b * cd.x + lift_c * db.x + lift_d * bc.x) * inverse;
  const double ay = (lift_b * cd.y + lift_c * db.y + lift_d * bc.y) * inverse;
  const double az = (lift_b * cd.z + lift_c * db.z + lift_d * bc.z) * inverse;
  const double axis = larger(std::fabs(ax), larger(std::fabs(ay), std::fabs(az)));
  t.axis[0] = ax;
  t.axis[1] = ay;
  t.axis[2] = az;
  const double error = inverse * u * (81 * r2 * r2 + 33 * r3 * axis) + 10 * u * axis;
  t.error = delta > 34 * u * r3 + 1e-200 ? static_cast<float>(error * 1.0001) + 1e-37f : HUGE_VALF;
}

}  // namespace fracture
