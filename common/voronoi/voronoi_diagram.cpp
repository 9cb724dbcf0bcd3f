#include "common/voronoi/voronoi_diagram.hpp"

#include <algorithm>
#include <string>

#include "common/base/error.hpp"
#include "common/exact/side.hpp"

namespace fracture {

VoronoiDiagram::VoronoiDiagram(const Tetrahedralization& tetrahedralization, const Box& box,
                               const std::optional<Matrix3>& map)
    : dual_(&tetrahedralization), map_(map) {
  const std::uint32_t sites = dual_->site_count();

  // Tetrahedra by site (counting sort), corners left out: no point of the box lies in their cells.
  tet_begin_.assign(sites + 1, 0);
  for (const Tetrahedron& t : dual_->tets)
    for (const SiteId s : t.v)
      if (s < sites) ++tet_begin_[s + 1];
  for (std::uint32_t s = 0; s < sites; ++s) tet_begin_[s + 1] += tet_begin_[s];
  tets_.resize(tet_begin_[sites]);
  std::vector<std::uint32_t> next(tet_begin_.begin(), tet_begin_.end() - 1);
  for (TetId t = 0; t < dual_->tets.size(); ++t)
    for (const SiteId s : dual_->tets[t].v)
      if (s < sites) tets_[next[s]++] = t;

  // Neighbours of each site.
  bisector_begin_.assign(sites + 1, 0);
  bisectors_.reserve(tets_.size());
  std::vector<std::uint32_t> seen(sites + 4, kNoSite);
  std::vector<SiteId> neighbors;
  for (SiteId i = 0; i < sites; ++i) {
    neighbors.clear();
    seen[i] = i;
    for (const TetId t : tetrahedra(i))
      for (const SiteId s : dual_->tets[t].v)
        if (seen[s] != i) {
          seen[s] = i;
          neighbors.push_back(s);
        }
    std::sort(neighbors.begin(), neighbors.end());

    // Rounding of value(): every difference and product is off by 2^-53 relative; |q - p_i| is at most
    // `reach` on each axis. Fewer than 16 roundings touch any term. With gradual underflow its products lose at
    // most 2^-1075 each beside, and so do those of this bound; there are fewer than 16, and 2^-1000 is more.
    const Vec3d& p = site(i);
    double reach = 0;
    for (int a = 0; a < 3; ++a)
      reach = std::max({reach, std::fabs(box.max[a] - p[a]), std::fabs(box.min[a] - p[a])});
    for (const SiteId j : neighbors) {
      const Vec3d u = site(j) - p;
      const double half = 0.5 * dot(u, u);
      const double norm1 = std::fabs(u.x) + std::fabs(u.y) + std::fabs(u.z);
      bisectors_.push_back({u, half, 0x1.0p-49 * (half + norm1 * reach) + 0x1p-1000, j});
    }
    bisector_begin_[i + 1] = static_cast<std::uint32_t>(bisectors_.size());
  }
}

int VoronoiDiagram::side(SiteId i, const Bisector& bisector, const Vec3d& q) const {
  const double v = value(i, bisector, q);
  if (v > bisector.error) return 1;
  if (v < -bisector.error) return -1;
  return exact::side1(site(i), site(bisector.neighbor), q);
}

SiteId VoronoiDiagram::nearest(const Vec3d& q, SiteId start) const {
  // In a (perturbed, hence generic) power diagram a site that beats all its neighbours is the nearest one,
  // and each step comes strictly closer, so the walk ends.
  SiteId i = start;
  for (;;) {
    // The most violated bisector: by value, the steepest descent in squared distance.
    double worst = 0;
    SiteId next = kNoSite;
    bool doubt = false;
    for (const Bisector& b : bisectors(i)) {
      const double v = value(i, b, q);
      if (v < -b.error) {
        if (v < worst) {
          worst = v;
          next = b.neighbor;
        }
      } else if (v <= b.error) {
        doubt = true;
      }
    }
    if (next == kNoSite && doubt) {
      for (const Bisector& b : bisectors(i))
        if (std::fabs(value(i, b, q)) <= b.error && exact::side1(site(i), site(b.neighbor), q) < 0) {
          next = b.neighbor;
          break;
        }
    }
    if (next == kNoSite) return i;
    if (dual_->is_corner(next))
      throw InternalError("nearest: a point of the box lies in the cell of a corner");
    i = next;
  }
}

VoronoiDiagram::Facet VoronoiDiagram::find_facet(SiteId i, SiteId j, SiteId k) const {
  for (const TetId t : tetrahedra(i)) {
    const auto& v = dual_->tets[t].v;
    int found = 0, other = -1;
    for (int m = 0; m < 4; ++m) {
      if (v[m] == i || v[m] == j || v[m] == k)
        ++found;
      else
        other = m;
    }
    if (found == 3) return {t, other};
  }
  throw InternalError("no Delaunay facet (" + std::to_string(i) + ", " + std::to_string(j) + ", " +
                      std::to_string(k) + ")");
}

}  // namespace fracture
