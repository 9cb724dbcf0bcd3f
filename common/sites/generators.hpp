// The patterns, two functions each, and what they share. A pattern without one of them does not compile.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/sites/column_sampler.hpp"
#include "common/sites/density.hpp"
#include "common/sites/pattern.hpp"

namespace fracture::sites_detail {

/// What every generator is told.
struct Task {
  const Solid& solid;     ///< the image
  const SeenSolid& seen;  ///< the same, with what it is an image of
  std::uint32_t count;    ///< > 0
  std::uint64_t seed;
  const Execution& execution;
  std::uint32_t most_sites;
  const Anisotropy& anisotropy;
  std::uint32_t cells_per_fragment = 1;  ///< of `count`
  const Density* density = nullptr;      ///< none: the same everywhere
};

/// From the frame of the answer to the image.
using ImageMap = CellMap;

/// The pattern's sites in the image of the solid under `map` (Task::solid is that image), unsnapped. Places
/// and directions of the pattern are in the frame of the answer.
Expected<SitePlan> generate(const Task& task, const UniformPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const PointsPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const ImpactPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const RadialPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const GridPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const BrickPattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const SlicePattern& pattern, const ImageMap& map);
Expected<SitePlan> generate(const Task& task, const ClusteredPattern& pattern, const ImageMap& map);

/// About how many sites that makes, within a factor of two, of a solid with a box of these sides (metres),
/// where SiteParameters::sites is `count`. Costs nothing: no solid is looked at.
double expected_sites(const UniformPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const PointsPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const ImpactPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const RadialPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const GridPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const BrickPattern& pattern, double count, const Vec3d& sides);
double expected_sites(const SlicePattern& pattern, double count, const Vec3d& sides);
double expected_sites(const ClusteredPattern& pattern, double count, const Vec3d& sides);

/// Whether each part breaks as its shape has it (sites/shapes.hpp): where nothing of the wheel is given but its centre.
bool breaks_by_parts(const RadialPattern& pattern);

/// Places of the frame of the answer in the image, of a map that has one frame at most.
std::vector<Vec3d> mapped(std::vector<Vec3d> points, const ImageMap& map);
/// The box of the solid in the image; where that has several frames, one like that of each of them together.
Box box_in_image(const Task& task);
/// How many boxes with the sides `cell` cover a box with the sides `sides`.
double boxes_in(const Vec3d& sides, const Vec3d& cell);

/// Points in the solid, as close to each other as Task::density says; the first n of more are those of n.
std::vector<Vec3d> even_points(const Task& task, ColumnSampler& sampler, std::uint32_t count);

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
