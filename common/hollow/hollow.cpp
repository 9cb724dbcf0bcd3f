#include "common/hollow/hollow.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/hollow/deep_points.hpp"
#include "common/hollow/extended_source.hpp"
#include "common/hollow/inner_surface.hpp"
#include "common/solid/corners.hpp"

namespace fracture {
namespace {

using hollow_detail::corners_of;
using hollow_detail::ExtendedSource;
using hollow_detail::InnerSurface;

/// The triangles of a part: they follow one another.
struct Run {
  std::size_t begin = 0, end = 0;
};

std::vector<Run> runs_of_parts(const Solid& solid) {
  std::vector<Run> runs(solid.parts.size());
  for (std::size_t t = 0; t < solid.part.size(); ++t) {
    Run& run = runs[solid.part[t]];
    if (run.end == 0) run.begin = t;
    run.end = t + 1;
  }
  return runs;
}

/// A surface of one part, divided into the shells that hang together.
struct Cavity {
  std::size_t part;
  InnerSurface surface;
  std::vector<std::uint32_t> shell_of_triangle;
  std::uint32_t shells = 0;
};

std::vector<std::uint32_t> shells_of(const InnerSurface& surface, std::uint32_t& count) {
  DisjointSets sets;
  sets.reserve(surface.positions.size());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) sets.add();
  for (const auto& [a, b, c] : surface.triangles) {
    sets.unite(a, b);
    sets.unite(a, c);
  }
  std::vector<std::uint32_t> number(surface.positions.size(), kNoIndex), shells;
  shells.reserve(surface.triangles.size());
  for (const auto& triangle : surface.triangles) {
    std::uint32_t& n = number[sets.find(triangle[0])];
    if (n == kNoIndex) n = count++;
    shells.push_back(n);
  }
  return shells;
}

/// The middle of a part's box is the origin of volumes, so that little is lost to rounding.
double volume_of(const InnerSurface& surface, const Vec3d& origin) {
  double six = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    six -= dot(a - origin, cross(b - origin, c - origin));
  }
  return six / 6;
}

/// Adds what the walls of a part measure; sums of thickness times area, which the caller divides.
void measure(const InnerSurface& surface, const SurfaceTree& outside, SolidReport& report, double& area,
             Pacer& pacer) {
  // Nothing is farther from the outside than its neighbour is, and that one from it.
  constexpr double kBeyondRounding = 1 + 1e-9;
  const auto depth_near = [&](const Vec3d& p, const Vec3d& q, double depth) {
    return outside.distance(p, kBeyondRounding * (depth + length(p - q)), pacer);
  };
  double least = report.parts_hollowed == 0 ? HUGE_VAL : report.least_thickness;
  std::vector<double> depths;
  depths.reserve(surface.positions.size());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const Vec3d p = to_double(surface.positions[v]);
    depths.push_back(v == 0 ? outside.distance(p, HUGE_VAL, pacer)
                            : depth_near(p, to_double(surface.positions[v - 1]), depths.back()));
    least = std::fmin(least, depths.back());
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    const double size = length(cross(b - a, c - a)) / 2;
    const double thickness = depth_near((1.0 / 3) * (a + b + c), a, depths[surface.triangles[t][0]]);
    least = std::fmin(least, thickness);
    report.mean_thickness += thickness * size;
    area += size;
  }
  report.least_thickness = least;
}

/// Divides the sum of thicknesses by the area, and says in words what the figures do not.
void finish(SolidReport& report, const HollowOptions& options, std::uint32_t asked, double area) {
  const std::uint64_t solid = asked - report.parts_hollowed;
  if (options.least_ball > 0 && report.parts_hollowed > 0)
    report.notes.push_back(
        std::to_string(report.parts_hollowed) +
        " closed parts that hold a ball of some size became walls, as 'shell_ball' has it; "
        "shell=0 keeps them solid.");
  if (solid > 0)
    report.notes.push_back(
        std::to_string(solid) + " of " + std::to_string(asked) +
        " closed parts stayed solid: nowhere are they thick enough for walls, or there are too "
        "many parts.");
  if (area > 0) report.mean_thickness /= area;
  if (options.thickness > 0 && report.mean_thickness > 2 * options.thickness)
    report.notes.push_back("Walls are " +
                           std::to_string(std::lround(report.mean_thickness / options.thickness)) +
                           " times as thick as 'shell' asks: thinner ones take more triangles than may be.");
}

/// Triangles of the lattice for each that a part may have: more are work for nothing where many parts share them.
constexpr std::uint32_t kMarched = 4;

std::uint32_t most_marched(std::size_t triangles) {
  return static_cast<std::uint32_t>(
      std::min<std::size_t>(kMarched * triangles, HollowOptions{}.max_triangles));
}

/// Of walls that a material has by itself every fracture pays for the triangles: no finer than the outside asks for, and
/// those of an eye no finer than those of its head. `share`: of the longest side of the largest part.
hollow_detail::InnerSurfaceLimits fine_enough(std::size_t outside, double share, std::uint32_t most) {
  constexpr std::size_t kForEach = 4, kLarge = 4000, kLeast = 1000;
  const auto of_size = static_cast<std::size_t>(kLarge * share * share);
  const std::size_t triangles = std::min<std::size_t>(most, std::max({kForEach * outside, of_size, kLeast}));
  return {static_cast<std::uint32_t>(triangles), most_marched(triangles)};
}

/// Writes the parts anew, each with its cavity behind its own triangles.
class Rebuilder {
 public:
  Rebuilder(Solid& solid, const std::vector<Cavity>& cavities, const Execution& execution)
      : solid_(solid),
        cavities_(cavities),
        pacer_(execution),
        corners_(sum(&InnerSurface::positions)),
        added_(sum(&InnerSurface::triangles)),
        source_(*solid.source, corners_, added_, execution) {}

  void run() {
    const std::vector<Run> runs = runs_of_parts(solid_);
    reserve();
    auto next = cavities_.begin();
    for (std::size_t p = 0; p < solid_.parts.size(); ++p) {
      for (std::size_t t = runs[p].begin; t < runs[p].end; ++t) copy(t);
      if (next != cavities_.end() && next->part == p) add(*next++);
    }
    solid_.triangles = std::move(triangles_);
    solid_.wedges = std::move(wedges_);
    solid_.material = std::move(material_);
    solid_.edges = std::move(edges_);
    solid_.shell = std::move(shell_);
    solid_.part = std::move(part_);
    solid_.source = std::move(source_).finished();
  }

 private:
  template <class List>
  std::size_t sum(List InnerSurface::*list) const {
    std::size_t count = 0;
    for (const Cavity& cavity : cavities_) count += (cavity.surface.*list).size();
    return count;
  }

  void reserve() {
    const std::size_t count = solid_.triangles.size() + added_;
    triangles_.reserve(count);
    wedges_.reserve(count);
    material_.reserve(count);
    edges_.reserve(count);
    shell_.reserve(count);
    part_.reserve(count);
    solid_.positions.reserve(solid_.positions.size() + corners_);
  }

  void copy(std::size_t t) {
    pacer_.step();
    triangles_.push_back(solid_.triangles[t]);
    wedges_.push_back(solid_.wedges[t]);
    material_.push_back(solid_.material[t]);
    edges_.push_back(solid_.edges[t]);
    shell_.push_back(solid_.shell[t]);
    part_.push_back(solid_.part[t]);
  }

  void add(const Cavity& cavity) {
    const auto first_vertex = static_cast<std::uint32_t>(solid_.positions.size());
    Part& part = solid_.parts[cavity.part];
    const std::uint32_t first_wedge = source_.add_wedges(cavity.surface);
    solid_.positions.insert(solid_.positions.end(), cavity.surface.positions.begin(),
                            cavity.surface.positions.end());
    const auto first_shell = static_cast<std::uint32_t>(solid_.report.shells);
    for (std::uint32_t s = 0; s < cavity.shells; ++s) part.shells.push_back(first_shell + s);
    solid_.report.shells += cavity.shells;
    solid_.report.cavities += cavity.shells;
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> edge_of;
    for (std::size_t t = 0; t < cavity.surface.triangles.size(); ++t) {
      pacer_.step(16);
      const auto& corner = cavity.surface.triangles[t];
      std::array<VertexId, 3>& triangle = triangles_.emplace_back();
      std::array<std::uint32_t, 3>&wedges = wedges_.emplace_back(), &edges = edges_.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        triangle[k] = VertexId{first_vertex + corner[k]};
        wedges[k] = first_wedge + corner[k];
        const auto [low, high] = std::minmax(corner[k], corner[(k + 1) % 3]);
        const auto [edge, is_new] =
            edge_of.try_emplace({low, high}, static_cast<std::uint32_t>(solid_.edge_vertices.size()));
        if (is_new)
          solid_.edge_vertices.push_back({VertexId{first_vertex + low}, VertexId{first_vertex + high}});
        edges[k] = edge->second;
      }
      material_.push_back(kCavityMaterial);
      shell_.push_back(first_shell + cavity.shell_of_triangle[t]);
      part_.push_back(static_cast<std::uint32_t>(cavity.part));
      source_.add_triangle(wedges, part);
    }
  }

  Solid& solid_;
  const std::vector<Cavity>& cavities_;
  Pacer pacer_;
  std::size_t corners_, added_;
  ExtendedSource source_;
  std::vector<std::array<VertexId, 3>> triangles_;
  std::vector<std::array<std::uint32_t, 3>> wedges_, edges_;
  std::vector<std::uint32_t> material_, shell_, part_;
};

}  // namespace

Solid hollowed(Solid solid, const HollowOptions& options, const Execution& execution) {
  if (!options.any()) return solid;
  Pacer pacer(execution);
  SolidReport& report = solid.report;
  const std::vector<Run> runs = runs_of_parts(solid);
  const auto thickness_of = [&](const Part& part) {
    return options.thickness > 0 ? options.thickness : options.fraction * part.box.longest_side();
  };
  const double least_ball = options.least_ball > 0 ? std::fmax(options.least_ball, kSmallestBall) : 0;
  const auto surface_of = [&](std::size_t p) {
    return SurfaceTree(corners_of(solid, runs[p].begin, runs[p].end, execution), execution);
  };
  const auto may = [&](std::size_t p) {
    const Part& part = solid.parts[p];
    const Vec3d size = part.box.size();
    const double longest = part.box.longest_side(), shortest = std::fmin(size.x, std::fmin(size.y, size.z));
    if (part.shells.size() > 1 || !(shortest > std::fmax(2 * thickness_of(part), least_ball * longest)))
      return false;
    return least_ball == 0 ||
           hollow_detail::holds_ball(surface_of(p), part.box, least_ball / 2 * longest, execution);
  };
  execution.reaches(0.2);
  std::vector<std::size_t> chosen;
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step(8);
    if (may(p)) chosen.push_back(p);
  }
  auto waiting = static_cast<std::uint32_t>(chosen.size());
  const std::uint32_t asked = waiting;
  double longest = 0;
  for (const std::size_t p : chosen) longest = std::fmax(longest, solid.parts[p].box.longest_side());
  std::uint32_t left = options.max_all;
  std::vector<Cavity> cavities;
  double area = 0;
  for (const std::size_t p : chosen) {
    Part& part = solid.parts[p];
    execution.poll();
    execution.reaches(0.2 + 0.6 * (asked - waiting + 1) / asked);
    const std::uint32_t most = std::min(options.max_triangles, left / waiting--);
    if (most < kLeastTriangles) continue;
    const hollow_detail::InnerSurfaceLimits limits =
        least_ball > 0 ? fine_enough(runs[p].end - runs[p].begin, part.box.longest_side() / longest, most)
                       : hollow_detail::InnerSurfaceLimits{.triangles = most, .marched = most_marched(most)};
    const SurfaceTree outside = surface_of(p);
    Cavity cavity{p, inner_surface(outside, part.box, thickness_of(part), limits, execution), {}};
    const double volume = volume_of(cavity.surface, part.box.center());
    // A surface that crosses itself may enclose less than its deep places do.
    if (cavity.surface.triangles.empty() || volume >= part.volume) continue;
    left -= static_cast<std::uint32_t>(cavity.surface.triangles.size());
    execution.made(Product::kSurfaceTriangles, cavity.surface.triangles.size());
    cavity.shell_of_triangle = shells_of(cavity.surface, cavity.shells);
    measure(cavity.surface, outside, report, area, pacer);
    part.volume -= volume;
    report.absolute_volume += volume;
    ++report.parts_hollowed;
    report.hollow_triangles += cavity.surface.triangles.size();
    report.hollow_volume += volume;
    cavities.push_back(std::move(cavity));
  }
  finish(report, options, asked, area);
  if (cavities.empty()) return solid;
  report.area += area;
  report.volume = 0;
  for (const Part& part : solid.parts) report.volume += part.volume;
  execution.reaches(1);
  Rebuilder(solid, cavities, execution).run();
  return solid;
}

}  // namespace fracture
