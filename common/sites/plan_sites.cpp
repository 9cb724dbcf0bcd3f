#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "common/base/hilbert_curve.hpp"
#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/generators.hpp"
#include "common/sites/grain.hpp"
#include "common/sites/masonry.hpp"
#include "common/sites/request_places.hpp"
#include "common/sites/shapes.hpp"
#include "common/sites/sites.hpp"
#include "common/solid/image.hpp"

namespace fracture {
namespace {

using sites_detail::Task;

/// Makes the map's determinant positive. Distances under -A and A are the same.
Matrix3 positive(const Matrix3& map) { return map.determinant() < 0 ? -map : map; }

/// Compression along the grain: A = 1 + (1 / stretch - 1) g gᵀ.
Matrix3 along_grain(const Vec3d& direction, double stretch) {
  const Vec3d g = sites_detail::normalized(direction);
  Matrix3 map;
  for (int a = 0; a < 3; ++a) map.rows[a] = map.rows[a] + ((1 / stretch - 1) * g[a]) * g;
  return map;
}

Vec3d longest_side(const Box& box) {
  const Vec3d size = box.size();
  int axis = 1;  // of equal sides y, then x, because timber usually stands upright or extends along x
  for (const int a : {0, 2})
    if (size[a] > size[axis]) axis = a;
  Vec3d direction;
  direction[axis] = 1;
  return direction;
}

/// The map of parts that have one matrix each.
CellMap map_of(const Solid& solid, const std::vector<Matrix3>& matrices,
               const std::vector<std::uint8_t>& of_part, const Execution& execution) {
  if (matrices.size() == 1) return matrices[0];
  std::vector<Box> boxes(matrices.size());
  Pacer pacer(execution);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(2);
    const std::uint8_t k = of_part[solid.part[t]];
    for (const VertexId v : solid.triangles[t]) boxes[k].add(matrices[k] * to_double(solid.positions[v]));
  }
  return CellMap(matrices, of_part, boxes);
}

/// The map of parts that break separately. Each frame's box is twice the size of its parts, because rings may
/// extend that far beyond a part.
CellMap map_of_parts(const Solid& solid, const RadialPattern& pattern, const Execution& execution) {
  const Shapes shapes = sites_detail::shapes_for(solid, pattern, execution).shapes;
  if (shapes.frames < 2) return {};
  std::vector<Box> boxes(shapes.frames);
  Pacer pacer(execution);
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step(2);
    boxes[shapes.frame_of_part[p]].add(solid.parts[p].box.min);
    boxes[shapes.frame_of_part[p]].add(solid.parts[p].box.max);
  }
  for (Box& box : boxes) box = {box.center() - box.size(), box.center() + box.size()};
  return CellMap(std::vector<Matrix3>(shapes.frames), shapes.frame_of_part, boxes);
}

CellMap map_of(const Solid& solid, const SiteParameters& p, const Execution& execution) {
  const Anisotropy& anisotropy = p.anisotropy;
  if (anisotropy.matrix) return positive(anisotropy.matrix->inverse());
  std::vector<Matrix3> matrices;
  if (const auto* bricks = std::get_if<BrickPattern>(&p.pattern); bricks && anisotropy.stretch == 1) {
    const Masonry masonry = masonry_of(solid, !bricks->cell, CellMap::kMostFrames, execution);
    for (const Masonry::Frame& frame : masonry.frames) matrices.push_back(frame.axes);
    return map_of(solid, matrices, masonry.of_part, execution);
  }
  if (const auto* radial = std::get_if<RadialPattern>(&p.pattern);
      radial && sites_detail::breaks_by_parts(*radial) && anisotropy.stretch == 1)
    return map_of_parts(solid, *radial, execution);
  if (anisotropy.stretch == 1) return {};
  const auto along = [&](const Vec3d& grain) { return along_grain(grain, anisotropy.stretch); };
  if (anisotropy.grain) return along(*anisotropy.grain);
  if (anisotropy.grain_of == GrainOf::kSolid || !is_scattered(p.pattern))
    return along(longest_side(solid.box));
  const Grains grains =
      grains_of(solid, anisotropy.grain_of, longest_side(solid.box), CellMap::kMostFrames, execution);
  for (const Vec3d& grain : grains.directions) matrices.push_back(along(grain));
  return map_of(solid, matrices, grains.of_part, execution);
}

/// Orders the sites along a curve through the box. Cells that touch are then near each other in memory, even
/// among 100,000 sites, and are processed soon after one another.
void order_along_curve(const Box& box, SitePlan& plan, const Execution& execution) {
  constexpr int kBits = 20;
  struct Keyed {
    std::uint64_t key;
    std::uint32_t site;
    auto operator<=>(const Keyed&) const = default;
  };
  const HilbertCurve curve(box, kBits);
  Pacer pacer(execution);
  std::vector<Keyed> order;
  order.reserve(plan.points.size());
  for (const Vec3d& p : plan.points) {
    pacer.step(4);
    order.push_back({curve.at(p), static_cast<std::uint32_t>(order.size())});
  }
  sort_with_polls(execution, order.begin(), order.end());
  std::vector<Vec3d> points;
  std::vector<std::uint32_t> groups, bricks;
  points.reserve(plan.points.size());
  groups.reserve(plan.groups.size());
  bricks.reserve(plan.bricks.size());
  for (const Keyed& k : order) {
    pacer.step();
    points.push_back(plan.points[k.site]);
    if (!plan.groups.empty()) groups.push_back(plan.groups[k.site]);
    if (!plan.bricks.empty()) bricks.push_back(plan.bricks[k.site]);
  }
  plan.points = std::move(points);
  plan.groups = std::move(groups);
  plan.bricks = std::move(bricks);
}

/// For several families: maps to the coordinates q -> (n1·q, n2·q, n3·q), in which the slices are a grid.
/// With two families, the third direction is not divided.
Matrix3 map_of(const SlicePattern& slices) {
  Matrix3 map;
  for (std::size_t k = 0; k < slices.normals.size(); ++k)
    map.rows[k] = sites_detail::normalized(slices.normals[k]);
  if (slices.normals.size() == 2) map.rows[2] = sites_detail::normalized(cross(map.rows[0], map.rows[1]));
  return positive(map);
}

}  // namespace

namespace sites_detail {

Expected<SitePlan> generate(const Task& task, const UniformPattern&, const ImageMap&) {
  ColumnSampler sampler(task.solid, task.seed, task.execution);
  SitePlan plan;
  plan.points = even_points(task, sampler, task.count);
  return plan;
}

Expected<SitePlan> generate(const Task& task, const PointsPattern& pattern, const ImageMap& map) {
  SitePlan plan;
  check_points(task.seen.original(), pattern.points, plan.remarks, task.execution);
  plan.points = mapped(pattern.points, map);
  plan.groups = pattern.groups;
  return plan;
}

double expected_sites(const UniformPattern&, double count, const Vec3d&) { return count; }
double expected_sites(const PointsPattern&, double count, const Vec3d&) { return count; }

std::vector<Vec3d> mapped(std::vector<Vec3d> points, const ImageMap& map) {
  if (map)
    for (Vec3d& p : points) p = map.of_part(0).image(p);
  return points;
}

Box box_in_image(const Task& task) {
  const auto frames = task.seen.map().frames();
  if (frames.size() < 2) return task.solid.box;
  Box box;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d p = task.seen.original().box.min;
    for (int axis = 0; axis < 3; ++axis)
      if (corner >> axis & 1) p[axis] = task.seen.original().box.max[axis];
    box.add(frames[0].matrix * p);
  }
  return box;
}

double boxes_in(const Vec3d& sides, const Vec3d& cell) {
  double n = 1;
  for (int axis = 0; axis < 3; ++axis) n *= std::fmax(1, std::ceil(sides[axis] / cell[axis]));
  return n;
}

tl::unexpected<Error> too_many_sites(const Task& task, double sites, const char* pattern,
                                     const char* parameter, const char* change) {
  const std::string name = std::string("'") + parameter + "'";
  const bool by_number = std::string_view(parameter) == "sites";
  return fail(ErrorCode::kTooComplex,
              std::string("pattern=") + pattern + (by_number ? "" : " with this " + name) + " needs " +
                  grouped(static_cast<std::uint64_t>(std::fmin(sites, 1e15))) + " sites for this mesh; " +
                  site_limit(task.most_sites) + ". " +
                  (by_number ? std::string("Ask for fewer fragments or 'sites'.")
                             : std::string("Use ") + change + " " + name + "."),
              parameter);
}

}  // namespace sites_detail

std::string site_limit(std::uint64_t most) {
  return "the limit is " + grouped(most) + " (server option --max-sites)";
}

bool is_scattered(const SitePattern& pattern) {
  return std::holds_alternative<UniformPattern>(pattern) || std::holds_alternative<ImpactPattern>(pattern) ||
         std::holds_alternative<ClusteredPattern>(pattern);
}

std::uint32_t cells_per_fragment(const SiteParameters& parameters) {
  if (!is_scattered(parameters.pattern)) return 1;
  return std::clamp(parameters.aggregation.cells, 1u,
                    std::max(1u, kMaxPatternSites / std::max(1u, parameters.sites)));
}

double expected_sites(const SiteParameters& parameters, const Box& box) {
  const double count = 1.0 * parameters.sites * cells_per_fragment(parameters);
  return std::visit(
      [&](const auto& pattern) { return sites_detail::expected_sites(pattern, count, box.size()); },
      parameters.pattern);
}

Expected<CellMap> map_of_cells(const Solid& solid, const SiteParameters& p, const Execution& execution) {
  const auto* slices = std::get_if<SlicePattern>(&p.pattern);
  const bool oblique = slices && slices->normals.size() > 1;
  CellMap map = map_of(solid, p, execution);
  if (oblique && map)
    return fail(
        ErrorCode::kBadParameter,
        "Slices of several families cannot be stretched: leave out 'stretch', and give the final directions as 'normals'.",
        "stretch");
  if (oblique) map = map_of(*slices);
  if (map == CellMap(Matrix3{})) map = {};
  return map;
}

Expected<SitePlan> plan_sites(const SeenSolid& solid, const SiteParameters& p, const Execution& execution) {
  const std::uint32_t cells = cells_per_fragment(p), count = std::max(1u, p.sites) * cells;
  if (cells == 1 && is_scattered(p.pattern) && count > p.most_sites)
    return fail(ErrorCode::kTooComplex,
                counted(count, "site is", "sites are") + " requested; " + site_limit(p.most_sites) +
                    ". Ask for fewer 'sites'.",
                "sites");
  if (cells > 1 && count > p.most_sites)
    return fail(ErrorCode::kTooComplex,
                counted(p.sites, "fragment of ", "fragments of ") + std::to_string(cells) +
                    (p.sites == 1 ? " cells needs " : " cells each need ") + grouped(count) + " sites; " +
                    site_limit(p.most_sites) + ". Ask for fewer fragments, or lower 'cells_per_fragment'.",
                "cells_per_fragment");
  Task task{solid.seen(), solid, count, p.seed, execution, p.most_sites, p.anisotropy, cells};
  std::optional<sites_detail::Density> density;
  if (!p.density_from.empty() && is_scattered(p.pattern)) {
    auto made = sites_detail::Density::make(solid.original(), p.density_from, execution);
    if (!made) return tl::unexpected(made.error());
    task.density = &density.emplace(std::move(*made));
  }
  Expected<SitePlan> plan = std::visit(
      [&](const auto& pattern) { return sites_detail::generate(task, pattern, solid.map()); }, p.pattern);
  if (!plan) return plan;
  if (is_scattered(p.pattern) && cells < p.aggregation.cells)
    plan->remarks.warn(
        "'cells_per_fragment' is " + grouped(cells) + " here instead of " + grouped(p.aggregation.cells) +
        ", because the higher value needs more than " + grouped(kMaxPatternSites) +
        " sites. Fragments of fewer cells have plainer shapes. To get more cells in each, ask for fewer fragments.");
  plan->map = solid.map();
  if (!std::holds_alternative<PointsPattern>(p.pattern)) {
    const SiteLattice lattice = site_lattice(solid.seen().box);
    Pacer pacer(execution);
    for (Vec3d& site : plan->points) {
      pacer.step();
      site = lattice.snap(site);
    }
    order_along_curve(solid.seen().box, *plan, execution);
  }
  return plan;
}

void fill_frames(const SeenSolid& solid, SitePlan& plan, const Execution& execution) {
  const std::size_t frames = plan.map.frames().size();
  if (frames < 2) return;
  std::vector<bool> has_site(frames, false);
  std::size_t empty = frames;
  const auto fills = [&](const Vec3d& p) {
    const std::size_t frame = plan.map.index_at(p);
    if (has_site[frame]) return false;
    has_site[frame] = true;
    --empty;
    return true;
  };
  Pacer pacer(execution);
  for (std::size_t k = 0; k < plan.points.size() && empty > 0; ++k) {
    pacer.step();
    fills(plan.points[k]);
  }
  const SiteLattice lattice = site_lattice(solid.seen().box);
  const std::vector<Part>& parts = solid.seen().parts;
  for (std::size_t p = 0; p < parts.size() && empty > 0; ++p) {
    pacer.step();
    const Vec3d middle = lattice.snap(parts[p].box.center());
    if (!fills(middle)) continue;
    plan.points.push_back(middle);
    if (!plan.groups.empty())
      plan.groups.push_back(1 + *std::max_element(plan.groups.begin(), plan.groups.end()));
    if (!plan.bricks.empty()) plan.bricks.push_back(kNoIndex);
  }
}

Expected<SitePlan> plan_sites(const Solid& solid, const SiteParameters& p, const Execution& execution) {
  const Expected<CellMap> map = map_of_cells(solid, p, execution);
  if (!map) return tl::unexpected(map.error());
  return plan_sites(SeenSolid(solid, *map, execution), p, execution);
}

}  // namespace fracture
