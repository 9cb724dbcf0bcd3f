#include "common/contacts/crossings.hpp"

#include <algorithm>
#include <utility>

namespace fracture::contacts_detail {
namespace {

using Signs = std::array<int, 3>;
bool all_one(const Signs& s) { return s[0] == s[1] && s[1] == s[2]; }

}  // namespace

Crossings::Crossings(const Solid& solid, const NearPair& pair, std::vector<Corners> a, std::vector<Corners> b,
                     Pacer& pacer)
    : solid_(solid), pair_(pair), a_(std::move(a)), b_(std::move(b)), of_a_(a_.size()), of_b_(b_.size()) {
  pacer.step(a_.size() + b_.size());
  for (const Corners& c : a_) signs_.include(c);
  for (const Corners& c : b_) signs_.include(c);
  for (const auto& [i, k] : pair.pairs) {
    pacer.step(8);
    cross_pair(i, k, a_[i], b_[k]);
  }
}

/// Returns the place at which edge k of s meets the plane of t, and its parameter along the edge. Both
/// triangles at the edge get the same place.
std::pair<Vec3d, double> Crossings::place_on(const NearTriangle& s, std::size_t k,
                                             const NearTriangle& t) const {
  const auto& v = solid_.triangles[s.triangle];
  const bool turned = v[(k + 1) % 3] < v[k];
  const Vec3d &p = s.corners[turned ? (k + 1) % 3 : k], &q = s.corners[turned ? k : (k + 1) % 3];
  const double over_p = dot(t.normal, p - t.corners[0]), over_q = dot(t.normal, q - t.corners[0]);
  const double rise = over_p - over_q;
  const double x = rise != 0 ? std::clamp(over_p / rise, 0.0, 1.0) : 0.5;
  return {p + x * (q - p), turned ? 1 - x : x};
}

/// Adds a crossing: edge k of s passes through t, from outside to inside (jump 1) or back (-1). From this
/// place, the region of s inside the other part continues along the edge: the segment of s ends here, and
/// that of t begins.
void Crossings::add_crossing(Owner owner, std::uint32_t i, std::size_t k, const NearTriangle& t, int jump,
                             Ends& of_s, Ends& of_t) {
  const bool is_a = owner == Owner::kA;
  const NearTriangle& s = (is_a ? pair_.a : pair_.b)[i];
  Crossed& crossed = (is_a ? of_a_ : of_b_)[i];
  const auto [place, x] = place_on(s, k, t);
  crossed.jumps[k] += jump;
  (is_a ? jumps_a_ : jumps_b_).push_back({i, static_cast<std::uint32_t>(k), jump, x});
  if (k == 1) {
    crossed.jumps_at += jump * x;
    crossed.jumps_at_squares += jump * x * x;
  }
  (jump > 0 ? of_s.head : of_s.tail) = place;
  (jump > 0 ? of_s.has_head : of_s.has_tail) = true;
  (jump > 0 ? of_t.tail : of_t.head) = place;
  (jump > 0 ? of_t.has_tail : of_t.has_head) = true;
}

void Crossings::add_segment(Owner owner, std::uint32_t i, const Ends& ends) {
  const bool is_a = owner == Owner::kA;
  const NearTriangle& s = (is_a ? pair_.a : pair_.b)[i];
  Crossed& crossed = (is_a ? of_a_ : of_b_)[i];
  const Vec3d tail = ends.tail - s.corners[0], head = ends.head - s.corners[0];
  const Vec3d across = cross(tail, head);
  crossed.across = crossed.across + across;
  crossed.moment = crossed.moment + dot(s.normal, across) * (tail + head);
  crossed.crossed = true;
  (is_a ? lines_a_ : lines_b_).push_back({i, ends.tail, ends.head});
}

void Crossings::cross_pair(std::uint32_t i, std::uint32_t k, const Corners& a, const Corners& b) {
  Signs over_a, over_b;  // for the corners of b, and for those of a
  for (std::size_t c = 0; c < 3; ++c) over_a[c] = signs_.side(a, b[c], Owner::kB);
  if (all_one(over_a)) return;
  for (std::size_t c = 0; c < 3; ++c) over_b[c] = signs_.side(b, a[c], Owner::kA);
  if (all_one(over_b)) return;
  std::array<Signs, 3> passing;  // [edge of a][edge of b]
  for (std::size_t m = 0; m < 3; ++m)
    for (std::size_t n = 0; n < 3; ++n)
      passing[m][n] = signs_.passing(a[m], a[(m + 1) % 3], b[n], b[(n + 1) % 3], Owner::kA);
  const NearTriangle &s = pair_.a[i], &t = pair_.b[k];
  Ends of_a, of_b;
  for (std::size_t m = 0; m < 3; ++m) {
    if (over_b[m] != over_b[(m + 1) % 3] && all_one(passing[m]))
      add_crossing(Owner::kA, i, m, t, over_b[m], of_a, of_b);
    if (over_a[m] != over_a[(m + 1) % 3] && all_one({passing[0][m], passing[1][m], passing[2][m]}))
      add_crossing(Owner::kB, k, m, s, over_a[m], of_b, of_a);
  }
  if (!of_a.has_tail || !of_a.has_head) return;
  any_ = true;
  add_segment(Owner::kA, i, of_a);
  add_segment(Owner::kB, k, of_b);
}

std::vector<Corners> exact_corners(const PartSurfaces& surfaces, const std::vector<NearTriangle>& triangles) {
  std::vector<Corners> corners;
  corners.reserve(triangles.size());
  for (const NearTriangle& t : triangles) corners.push_back(surfaces.corners(t.triangle));
  return corners;
}

Patch inside_of(const NearTriangle& t, const Crossed& crossed, const std::array<int, 3>& windings) {
  const Vec3d &o = t.corners[0], e1 = t.corners[1] - o, e2 = t.corners[2] - o;
  if (!crossed.crossed) {
    const double area = windings[0] * t.area;
    return {area, area * (o + (1.0 / 3) * (e1 + e2))};
  }
  // On edge 1, the winding number at x is that at the edge's end, minus the jumps after x. These are its
  // integral, and its integral times 2 x:
  const double once = windings[2] - crossed.jumps_at, twice = windings[2] - crossed.jumps_at_squares;
  const double whole = 2 * t.area;
  const double area = 0.5 * (dot(t.normal, crossed.across) + whole * once);
  const Vec3d moment = (1.0 / 6) * crossed.moment + (whole / 3) * (once * e1 + (0.5 * twice) * (e2 - e1));
  return {area, area * o + moment};
}

}  // namespace fracture::contacts_detail
