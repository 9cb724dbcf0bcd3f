#include "common/pipeline/cell_shares.hpp"

#include <array>

#include "common/base/pacer.hpp"

namespace fracture {

void CellShares::add(SiteId site, double sign, const Vec3d& p, const Vec3d& q, const Vec3d& r) {
  const Vec3d a = p - origin_, b = q - origin_, c = r - origin_;
  const double six = sign * dot(a, cross(b, c));
  sum_[site].six_volume += six;
  sum_[site].moment = sum_[site].moment + six * (a + b + c);
}

CellShares::CellShares(const RestrictedDiagram& d, const Execution& execution)
    : sum_(d.diagram.dual().site_count()), origin_(d.solid.box.center()) {
  Pacer pacer(execution);
  const auto& polygons = d.cuts.polygons;
  std::size_t p = 0;
  for (std::uint32_t t = 0; t < d.solid.triangles.size(); ++t) {
    pacer.step(2);
    const std::array<CutVertexId, 3> v = d.corners(t);
    if (p == polygons.size() || polygons[p].triangle != t) {
      add(d.cuts.label[v[0]], 1, d.point(v[0]), d.point(v[1]), d.point(v[2]));
      continue;
    }
    for (; p < polygons.size() && polygons[p].triangle == t; ++p) {
      pacer.step(2 * polygons[p].count);
      const CutVertexId* ring = d.cuts.vertices.data() + polygons[p].first;
      for (std::uint32_t k = 2; k < polygons[p].count; ++k)
        add(polygons[p].cell, 1, d.point(ring[0]), d.point(ring[k - 1]), d.point(ring[k]));
    }
  }
  for (const CapRegion& region : d.caps.regions) {
    pacer.step(4 * region.triangle_count);
    for (std::uint32_t k = 0; k < region.triangle_count; ++k) {
      const auto& v = d.caps.triangles[region.first_triangle + k];
      const Vec3d a = d.point(v[0]), b = d.point(v[1]), c = d.point(v[2]);
      add(region.lo, 1, a, b, c);
      add(region.hi, -1, a, b, c);
    }
  }
}

std::optional<Vec3d> CellShares::center(SiteId site, double least_volume) const {
  const Sum& s = sum_[site];
  if (!(s.six_volume > 6 * least_volume)) return std::nullopt;
  return origin_ + (1 / (4 * s.six_volume)) * s.moment;
}

}  // namespace fracture
