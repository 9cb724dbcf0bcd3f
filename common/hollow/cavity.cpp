#include "common/hollow/cavity.hpp"

#include <cmath>

#include "common/base/disjoint_sets.hpp"
#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/hollow/extended_source.hpp"

namespace fracture::hollow_detail {
namespace {

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

/// Uses the middle of the part's box as the origin, which reduces rounding errors.
double volume_of(const InnerSurface& surface, const Vec3d& origin) {
  double six = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    six -= dot(a - origin, cross(b - origin, c - origin));
  }
  return six / 6;
}

void measure(Cavity& cavity, const SurfaceTree& outside, Pacer& pacer) {
  // The distance of a point to the outside is at most the distance of its neighbour plus the distance between
  // the two.
  constexpr double kBeyondRounding = 1 + 1e-9;
  const auto depth_near = [&](const Vec3d& p, const Vec3d& q, double depth) {
    return outside.distance(p, kBeyondRounding * (depth + length(p - q)), pacer);
  };
  const InnerSurface& surface = cavity.surface;
  double least = HUGE_VAL;
  std::vector<double> depths;
  depths.reserve(surface.positions.size());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const Vec3d p = to_double(surface.positions[v]);
    depths.push_back(v == 0 ? outside.distance(p, HUGE_VAL, pacer)
                            : depth_near(p, to_double(surface.positions[v - 1]), depths.back()));
    least = std::fmin(least, depths.back());
  }
  cavity.walls.reserve(surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto [a, b, c] = corners_of(surface, t);
    const double thickness = depth_near((1.0 / 3) * (a + b + c), a, depths[surface.triangles[t][0]]);
    least = std::fmin(least, thickness);
    cavity.walls.push_back({thickness, length(cross(b - a, c - a)) / 2});
  }
  // If the outside bends inwards, a large triangle may be nearest to it anywhere, usually at a point
  // within one of its edges. No point of a triangle is nearer than the distance of its middle minus the
  // triangle's radius.
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto corners = corners_of(surface, t);
    const Vec3d middle = (1.0 / 3) * (corners[0] + corners[1] + corners[2]);
    double radius = 0;
    for (const Vec3d& corner : corners) radius = std::fmax(radius, length(corner - middle));
    if (cavity.walls[t].thickness < kBeyondRounding * (least + radius))
      least = outside.distance_of(corners, least, pacer);
  }
  cavity.least_thickness = least;
}

}  // namespace

Cavity cavity_of(std::size_t part, const SurfaceTree& outside, const Box& box, double thickness,
                 const InnerSurfaceLimits& limits, const Execution& execution) {
  Cavity cavity;
  cavity.part = part;
  cavity.surface = inner_surface(outside, box, thickness, limits, execution, &cavity.other);
  cavity.volume = volume_of(cavity.surface, box.center());
  cavity.shell_of_triangle = shells_of(cavity.surface, cavity.shells);
  Pacer pacer(execution);
  measure(cavity, outside, pacer);
  return cavity;
}

}  // namespace fracture::hollow_detail
