#include "common/delaunay/tetrahedralization.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "common/delaunay/incremental.hpp"
#include "common/delaunay/spatial_order.hpp"

namespace fracture {
namespace {

bool in_range(const Vec3d& p) {
  for (int a = 0; a < 3; ++a)
    if (!(std::fabs(p[a]) <= kMaxSiteCoordinate)) return false;  // false for NaN too
  return true;
}

/// How many insertions ahead the coordinates are fetched: the order of insertion jumps about in the caller's
/// list.
constexpr std::size_t kPrefetch = 8;

double squared(double v) { return v * v; }

/// Squared distances from p to the nearest and the farthest point of the box.
double nearest2(const Box& box, const Vec3d& p) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) sum += squared(std::max({box.min[a] - p[a], p[a] - box.max[a], 0.0}));
  return sum;
}
double farthest2(const Box& box, const Vec3d& p) {
  double sum = 0;
  for (int a = 0; a < 3; ++a)
    sum += squared(std::max(std::fabs(p[a] - box.min[a]), std::fabs(p[a] - box.max[a])));
  return sum;
}

}  // namespace

Expected<Tetrahedralization> tetrahedralize(std::span<const Vec3d> sites, const Box& box,
                                            const Execution& execution) {
  if (sites.size() > kMaxSites)
    return fail(
        ErrorCode::kTooComplex,
        std::to_string(sites.size()) + " sites; at most " + std::to_string(kMaxSites) + " are accepted",
        "/points");
  for (std::size_t i = 0; i < sites.size(); ++i)
    if (!in_range(sites[i]))
      return fail(ErrorCode::kNotFinite, "a site's coordinates must be finite and at most 1e12 in magnitude",
                  "/points/" + std::to_string(i));
  if (!box.empty() && !(in_range(box.min) && in_range(box.max)))
    return fail(ErrorCode::kNotFinite, "the mesh's box must be finite and at most 1e12 in magnitude", "");

  // A site farther from the box than some other site's farthest point of the box owns no point in it. The
  // margin keeps the decision safe from rounding; a site kept needlessly costs time only.
  std::vector<std::uint32_t> kept;
  kept.reserve(sites.size());
  double reach2 = HUGE_VAL;
  if (!box.empty())
    for (const Vec3d& p : sites) reach2 = std::min(reach2, farthest2(box, p));
  for (std::uint32_t i = 0; i < sites.size(); ++i)
    if (box.empty() || nearest2(box, sites[i]) <= reach2 * (1 + 0x1p-40)) kept.push_back(i);

  Box domain = box;
  std::vector<Vec3d> points;
  points.reserve(kept.size());
  for (const std::uint32_t i : kept) {
    points.push_back(sites[i]);
    domain.add(sites[i]);
  }

  const auto limit = static_cast<std::uint32_t>(std::min<std::uint64_t>(
      kTetsAlways + kTetsPerSite * static_cast<std::uint64_t>(points.size()), 0x3ffffff0u));
  IncrementalDelaunay delaunay(big_tetrahedron(domain),
                               {IncrementalDelaunay::Method::kCavity, limit, &execution});
  delaunay.reserve(points.size());

  const std::vector<std::uint32_t> order = spatial_order(points, execution);
  // For each kept point the vertex it became; for each vertex the lowest kept point that it stands for.
  std::vector<VertexId> vertex_of(points.size());
  std::vector<std::uint32_t> first_of(points.size() + 4, 0xffffffffu);
  std::uint32_t counted = 0;
  const auto count_new = [&] {
    if (delaunay.tet_count() <= counted) return;
    execution.made(Product::kTetrahedra, delaunay.tet_count() - counted);
    counted = delaunay.tet_count();
  };
  StageProgress::Loop progress(execution.within, (order.size() + 63) / 64);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % 64 == 0) {
      execution.poll();
      progress.at(i / 64);
      count_new();
    }
    if (i + kPrefetch < order.size()) __builtin_prefetch(&points[order[i + kPrefetch]]);
    const auto [status, vertex] = delaunay.insert(points[order[i]]);
    if (status == IncrementalDelaunay::Status::kFull)
      return fail(ErrorCode::kTooComplex,
                  "the Delaunay tetrahedralization of these sites has more than " + std::to_string(limit) +
                      " tetrahedra (points on two skew lines make n^2/4 of them)",
                  "/points", {{"limit", limit}});
    if (status == IncrementalDelaunay::Status::kOutsideDomain)
      throw InternalError("a site outside its own domain");
    vertex_of[order[i]] = vertex;
    first_of[vertex] = std::min(first_of[vertex], order[i]);
  }

  count_new();

  // Sites are numbered by the first point that stands for them.
  std::vector<SiteId> site_of_vertex(delaunay.vertex_end(), kNoSite);
  SiteId next = 0;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    if (first_of[vertex_of[i]] == i) site_of_vertex[vertex_of[i]] = next++;
  Tetrahedralization result = delaunay.snapshot(site_of_vertex);
  result.site_of_input.assign(sites.size(), kNoSite);
  for (std::uint32_t i = 0; i < points.size(); ++i)
    result.site_of_input[kept[i]] = site_of_vertex[vertex_of[i]];
  result.duplicates_merged = static_cast<std::uint32_t>(points.size()) - next;
  result.far_sites_dropped = static_cast<std::uint32_t>(sites.size() - kept.size());
  return result;
}

}  // namespace fracture
