#include "common/pipeline/lloyd.hpp"

#include "common/base/pacer.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/sites/sites.hpp"

namespace fracture {
namespace {

/// Volume and first moment of each cell's share, by the divergence theorem over its faces about a common
/// origin: input triangles and their parts, and caps, which count for one cell and against the other.
class Shares {
 public:
  Shares(std::uint32_t sites, const Vec3d& origin) : sum_(sites), origin_(origin) {}

  void add(SiteId site, double sign, const Vec3d& p, const Vec3d& q, const Vec3d& r) {
    const Vec3d a = p - origin_, b = q - origin_, c = r - origin_;
    const double six = sign * dot(a, cross(b, c));
    sum_[site].six_volume += six;
    sum_[site].moment = sum_[site].moment + six * (a + b + c);
  }
  /// Nothing for a share without volume.
  std::optional<Vec3d> center(SiteId site, double least_volume) const {
    const Sum& s = sum_[site];
    if (!(s.six_volume > 6 * least_volume)) return std::nullopt;
    return origin_ + (1 / (4 * s.six_volume)) * s.moment;
  }

 private:
  struct Sum {
    double six_volume = 0;
    Vec3d moment;
  };
  std::vector<Sum> sum_;
  Vec3d origin_;
};

Shares measure(const RestrictedDiagram& d, const Execution& execution) {
  Pacer pacer(execution);
  Shares shares(d.diagram.dual().site_count(), d.solid.box.center());
  const auto& polygons = d.cuts.polygons;
  std::size_t p = 0;
  for (std::uint32_t t = 0; t < d.solid.triangles.size(); ++t) {
    pacer.step(2);
    const std::array<CutVertexId, 3> v = d.corners(t);
    if (p == polygons.size() || polygons[p].triangle != t) {
      shares.add(d.cuts.label[v[0]], 1, d.point(v[0]), d.point(v[1]), d.point(v[2]));
      continue;
    }
    for (; p < polygons.size() && polygons[p].triangle == t; ++p) {
      pacer.step(2 * polygons[p].count);
      const CutVertexId* ring = d.cuts.vertices.data() + polygons[p].first;
      for (std::uint32_t k = 2; k < polygons[p].count; ++k)
        shares.add(polygons[p].cell, 1, d.point(ring[0]), d.point(ring[k - 1]), d.point(ring[k]));
    }
  }
  for (const CapRegion& region : d.caps.regions) {
    pacer.step(4 * region.triangle_count);
    for (std::uint32_t k = 0; k < region.triangle_count; ++k) {
      const auto& v = d.caps.triangles[region.first_triangle + k];
      const Vec3d a = d.point(v[0]), b = d.point(v[1]), c = d.point(v[2]);
      shares.add(region.lo, 1, a, b, c);
      shares.add(region.hi, -1, a, b, c);
    }
  }
  return shares;
}

}  // namespace

Expected<void> relax(const SeenSolid& solid, SitePlan& plan, std::uint32_t passes,
                     const Execution& execution) {
  const SiteLattice lattice = site_lattice(solid.seen().box);
  // A sliver's centre of mass is mostly rounding error.
  const double least_volume = 1e-9 * solid.original().report.volume /
                              static_cast<double>(std::max<std::size_t>(1, plan.points.size()));
  Pacer pacer(execution);
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    const StageProgress::Part part(execution.within, (pass + 1.0) / passes);
    const Allowance::Temporary temporary(execution.allowance);  // what the pass makes goes with it
    const Expected<Tetrahedralization> t = tetrahedralize(plan.points, solid.seen().box, execution);
    if (!t) return tl::unexpected(t.error());
    const VoronoiDiagram diagram(*t, solid.seen().box, plan.map, execution);
    const Shares shares = measure(restrict_to_solid(solid, diagram, execution), execution);
    for (std::size_t k = 0; k < plan.points.size(); ++k) {
      pacer.step(4);
      const SiteId site = t->site_of_input[k];
      if (site == kNoSite) continue;
      const std::optional<Vec3d> center = shares.center(site, least_volume);
      if (center)
        plan.points[k] = lattice.snap(plan.map ? plan.map.at(plan.points[k]).image(*center) : *center);
    }
  }
  return {};
}

}  // namespace fracture
