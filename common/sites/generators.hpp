// Declares two functions for each pattern, and shared code. A pattern without one of these functions does not
// compile.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/sites/column_sampler.hpp"
#include "common/sites/density.hpp"
#include "common/sites/part_shares.hpp"
#include "common/sites/pattern.hpp"
#include "common/sites/shapes.hpp"

namespace fracture::sites_detail {

/// The input of every generator.
struct Task {
  const Solid& solid;     ///< the image
  const SeenSolid& seen;  ///< the image together with its original
  std::uint32_t count;    ///< > 0
  std::uint64_t seed;
  const Execution& execution;
  std::uint32_t most_sites;
  const Anisotropy& anisotropy;
  std::uint32_t cells_per_fragment = 1;  ///< how many of the `count` cells form a fragment
  const Density* density = nullptr;      ///< null: the same density everywhere
};

/// Maps from the frame of the answer to the image.
using ImageMap = CellMap;

/// Returns the pattern's sites, not snapped, in the image of the solid under `map` (Task::solid is that
/// image). Points and directions of the pattern are in the frame of the answer.
Expected<SitePlan> generate(const Task& task, const UniformPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const PointsPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const ImpactPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const RadialPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const GridPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const BrickPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const SlicePattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const ClusteredPattern& pattern, const ImageMap& map);

/// Estimates the number of sites, within a factor of two, for a solid with a box of these sides (m) if
/// SiteParameters::sites is `count`. Takes constant time, because it does not look at the solid.
double expected_sites(const UniformPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const PointsPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const ImpactPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const RadialPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const GridPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const BrickPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const SlicePattern& pattern, double count, const Vec3d& sides);
double expected_sites(const ClusteredPattern& pattern, double count, const Vec3d& sides);

/// Whether each part breaks according to its own shape (sites/shapes.hpp): true for Around::kShape if neither
/// axis, spokes nor rings are given.
bool breaks_by_parts(const RadialPattern& pattern);
/// The shapes of the parts. Parts that get the most pieces have frames of their own.
struct ShapesForPieces {
  std::optional<PartShares> shares;  ///< none: pieces are shared by volume
  Shapes shapes;
};
ShapesForPieces shapes_for(const Solid& solid, const RadialPattern& pattern, const Execution& execution);

/// Maps points from the frame of the answer to the image. The map has at most one frame.
std::vector<Vec3d> mapped(std::vector<Vec3d> points, const ImageMap& map);
/// The solid's box in the image. If the map has several frames, a box typical of one frame.
Box box_in_image(const Task& task);
/// Number of boxes with the sides `cell` that cover a box with the sides `sides`.
double boxes_in(const Vec3d& sides, const Vec3d& cell);

/// Returns points in the solid, spaced according to Task::density. A call with a smaller count returns a
/// prefix.
std::vector<Vec3d> even_points(const Task& task, ColumnSampler& sampler, std::uint32_t count);

/// A point around which sites lie with a density that falls as distance^-exponent out to the radius.
struct Cloud {
  Vec3d center;
  double radius;
};
/// Returns, for each entry of `cloud_of` (an index into clouds), a point of that cloud inside the solid. If
/// kDraws draws all miss, because very little of the cloud is inside the solid, the entry is left out.
std::vector<Vec3d> points_in_clouds(const Task& task, ColumnSampler& sampler, std::span<const Cloud> clouds,
                                    std::span<const std::uint32_t> cloud_of, double exponent);
inline constexpr int kDraws = 64;

/// Returns about `count` points near the impacts (in the frame of the answer), divided among the parts by
/// PartShares::near. There are fewer if too little of a part is within the radius.
std::vector<Vec3d> points_near_parts(const Task& task, std::span<const Vec3d> impacts, double radius,
                                     double exponent, const PartShares& shares, std::uint32_t count);

/// Error of a pattern that would generate `sites` sites. `parameter` sets their number, and `change` says how to get fewer: "a
/// larger". For 'sites', the advice is always to ask for fewer.
tl::unexpected<Error> too_many_sites(const Task& task, double sites, const char* pattern,
                                     const char* parameter = "sites", const char* change = "");

}  // namespace fracture::sites_detail
