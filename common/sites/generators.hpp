// The patterns, one function each, and what they share. All work in the image of the solid (pattern.hpp);
// places given by the caller have been mapped already. Points come back unsnapped.
#pragma once

#include "common/sites/column_sampler.hpp"
#include "common/sites/pattern.hpp"

namespace fracture::sites_detail {

/// What every generator is told.
struct Task {
  const Solid& solid;
  std::uint32_t count;  ///< > 0
  std::uint64_t seed;
  const Execution& execution;
  std::uint32_t most_sites;
};

Expected<SitePlan> impact_sites(const Task& task, const ImpactPattern& pattern);
Expected<SitePlan> radial_sites(const Task& task, const RadialPattern& pattern);
Expected<SitePlan> grid_sites(const Task& task, const GridPattern& pattern);
Expected<SitePlan> brick_sites(const Task& task, const BrickPattern& pattern);
/// One family of planes. Several families: grid_sites of their image.
Expected<SitePlan> slice_sites(const Task& task, const SlicePattern& pattern);
Expected<SitePlan> clustered_sites(const Task& task, const ClusteredPattern& pattern);

/// A point around which sites lie with a density that falls as distance^-exponent out to the radius.
struct Cloud {
  Vec3d center;
  double radius;
};
/// For each entry of `cloud_of` (an index into clouds) a point of that cloud inside the solid. A cloud of
/// which so little lies in the solid that kDraws draws all miss it gives nothing: such entries are left out.
std::vector<Vec3d> points_in_clouds(const Task& task, ColumnSampler& sampler, std::span<const Cloud> clouds,
                                    std::span<const std::uint32_t> cloud_of, double exponent);
inline constexpr int kDraws = 64;

/// Error of a pattern that would make `sites` of them.
tl::unexpected<Error> too_many_sites(const Task& task, double sites);

}  // namespace fracture::sites_detail
