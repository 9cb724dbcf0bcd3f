#include "common/delaunay/tetrahedralization.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "common/delaunay/box_distance.hpp"
#include "common/delaunay/insert_all.hpp"

namespace fracture {
namespace delaunay_detail {
namespace {

bool in_range(const Vec3d& p) {
  for (int a = 0; a < 3; ++a)
    if (!(std::fabs(p[a]) <= kMaxSiteCoordinate)) return false;  // also false for NaN
  return true;
}

}  // namespace

Expected<KeptSites> keep_sites(std::span<const Vec3d> sites, const Box& box) {
  if (sites.size() > kMaxSites)
    return fail(ErrorCode::kTooComplex,
                std::to_string(sites.size()) + " sites were given; at most " + std::to_string(kMaxSites) +
                    " are allowed.",
                "/points");
  if (!box.empty() && !(in_range(box.min) && in_range(box.max)))
    return fail(ErrorCode::kNotFinite,
                "The coordinates of the mesh's bounding box must be finite and at most 1e12 in magnitude.",
                "");
  for (std::size_t i = 0; i < sites.size(); ++i)
    if (!in_range(sites[i]))
      return fail(ErrorCode::kNotFinite,
                  "The coordinates of a site must be finite and at most 1e12 in magnitude.",
                  "/points/" + std::to_string(i));

  KeptSites kept;
  kept.given = sites.size();
  kept.input.reserve(sites.size());
  double reach2 = HUGE_VAL;
  if (!box.empty())
    for (const Vec3d& p : sites) reach2 = std::min(reach2, farthest2(box, p));
  for (std::uint32_t i = 0; i < sites.size(); ++i)
    if (box.empty() || is_near_enough(nearest2(box, sites[i]), reach2)) kept.input.push_back(i);

  kept.domain = box;
  kept.points.reserve(kept.input.size());
  for (const std::uint32_t i : kept.input) {
    kept.points.push_back(sites[i]);
    kept.domain.add(sites[i]);
  }
  kept.max_tets = static_cast<std::uint32_t>(std::min<std::uint64_t>(
      kTetsAlways + kTetsPerSite * static_cast<std::uint64_t>(kept.points.size()), 0x3ffffff0u));
  return kept;
}

Tetrahedralization numbered(IncrementalDelaunay& delaunay, const KeptSites& sites,
                            const std::vector<TetVertexId>& vertex_of) {
  // Sites are numbered by the first point at their position.
  const auto count = static_cast<std::uint32_t>(sites.points.size());
  std::vector<SiteId> site_of_vertex(delaunay.vertex_end(), kNoSite);
  SiteId next{0};
  for (std::uint32_t i = 0; i < count; ++i)
    if (SiteId& site = site_of_vertex[vertex_of[i]]; site == kNoSite) site = next++;
  Tetrahedralization result = delaunay.take_snapshot(site_of_vertex);
  result.site_of_input.assign(sites.given, kNoSite);
  for (std::uint32_t i = 0; i < count; ++i)
    result.site_of_input[sites.input[i]] = site_of_vertex[vertex_of[i]];
  result.duplicates_merged = count - next;
  result.far_sites_dropped = static_cast<std::uint32_t>(sites.given) - count;
  return result;
}

}  // namespace delaunay_detail

Expected<Tetrahedralization> tetrahedralize(std::span<const Vec3d> sites, const Box& box,
                                            const Execution& execution) {
  const Expected<delaunay_detail::KeptSites> kept = delaunay_detail::keep_sites(sites, box);
  if (!kept) return tl::unexpected(kept.error());
  IncrementalDelaunay delaunay(big_tetrahedron(kept->domain), {kept->max_tets, &execution});
  return delaunay_detail::insert_all(delaunay, *kept, execution,
                                     [&](const Vec3d& p) { return delaunay.insert(p); });
}

}  // namespace fracture
