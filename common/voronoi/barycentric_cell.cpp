#include "common/voronoi/barycentric_cell.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace fracture {
namespace {

struct Plane {
  Vec3d normal;   ///< unit, outward
  double offset;  ///< normal·x + offset = 0
};

/// Returns the planes of the convex hull's facets, with coplanar facets merged; empty if the points are flat.
std::vector<Plane> hull_planes(std::vector<Vec3d> points) {
  static_assert(sizeof(Vec3d) == 3 * sizeof(coordT));
  std::vector<Plane> planes;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> silence(std::fopen("/dev/null", "w"), &std::fclose);
  qhT state;
  qhT* qh = &state;
  qh_zero(qh, silence.get());
  char options[] = "qhull Pp";
  const int failed = qh_new_qhull(qh, 3, static_cast<int>(points.size()), &points[0].x, False, options,
                                  nullptr, silence.get());
  if (!failed) {
    facetT* facet;
    FORALLfacets planes.push_back({{facet->normal[0], facet->normal[1], facet->normal[2]}, facet->offset});
  }
  qh_freeqhull(qh, !qh_ALL);
  int long_blocks, long_bytes;
  qh_memfreeshort(qh, &long_blocks, &long_bytes);
  return planes;
}

}  // namespace

std::optional<std::vector<Vec3d>> barycentric_cell(const VoronoiDiagram& diagram, SiteId i) {
  const Tetrahedralization& dual = diagram.dual();
  std::vector<Vec3d> barycenters;
  for (const TetId t : diagram.tetrahedra(i)) {
    std::array<SiteId, 4> v = dual.tets[t].v;
    std::sort(v.begin(), v.end());
    barycenters.push_back(
        0.25 * (((dual.points[v[0]] + dual.points[v[1]]) + dual.points[v[2]]) + dual.points[v[3]]));
  }
  std::sort(barycenters.begin(), barycenters.end(), lexicographic_less);
  if (barycenters.size() < 4) return std::nullopt;
  if (const std::size_t all = barycenters.size(); all > kMostBarycenters) {
    for (std::size_t k = 0; k < kMostBarycenters; ++k)
      barycenters[k] = barycenters[k * (all - 1) / (kMostBarycenters - 1)];
    barycenters.resize(kMostBarycenters);
  }
  // The mirror centre must be inside the hull. The site itself sometimes is not, but the mean of the hull's
  // points always is.
  Vec3d p;
  for (const Vec3d& b : barycenters) p = p + b;
  p = (1.0 / static_cast<double>(barycenters.size())) * p;
  std::vector<Vec3d> sites{p};
  for (const Plane& plane : hull_planes(barycenters)) {
    const double distance = dot(plane.normal, p) + plane.offset;
    if (!(distance < 0)) return std::nullopt;
    sites.push_back(p - (2 * distance) * plane.normal);
  }
  if (sites.size() < 5) return std::nullopt;
  return sites;
}

}  // namespace fracture
