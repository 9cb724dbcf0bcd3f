#include "common/rough/roughen.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/pacer.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/rough/cap_normals.hpp"
#include "common/rough/displacement.hpp"
#include "common/rough/moving_caps.hpp"
#include "common/rough/refine.hpp"
#include "common/solid/corners.hpp"

namespace fracture {
namespace {

/// Minimum length of an edge, in lattice steps.
constexpr double kLeastSteps = 32;
/// Distance to the outer surface, in edge lengths, within which a cut has only the corners of its outline
/// (refine.hpp, with a margin). These corners would move individually, with straight strips between them, as
/// across a thin wall.
constexpr double kOutlineAlone = 0.7;

/// Uses Newton's iteration with only + * /, because the C library's cbrt is not rounded alike on all systems.
double cube_root(double v) {
  int exponent = 0;
  const double mantissa = std::frexp(v, &exponent);  // v = mantissa 2^exponent, in [0.5, 1)
  const int third = exponent >= 0 ? exponent / 3 : (exponent - 2) / 3;
  const double rest = std::ldexp(mantissa, exponent - 3 * third);  // in [0.5, 4)
  double x = 1.2;
  for (int k = 0; k < 8; ++k) x = (2 * x + rest / (x * x)) / 3;
  return std::ldexp(x, third);
}

double size_of(const Solid& solid) {
  double largest = 0;
  for (const Part& part : solid.parts) largest = std::fmax(largest, part.volume);
  return cube_root(largest);
}

template <class Wanted>
double area_of(const Caps& caps, const VertexPositions& positions, const Wanted& wanted,
               const Execution& execution) {
  Pacer pacer(execution);
  const auto at = [&](CutVertexId v) { return positions.points[v - positions.first_constructed]; };
  double twice = 0;
  for (const CapRegion& r : caps.regions) {
    pacer.step(1 + r.triangle_count);
    if (!wanted(r.lo, r.hi)) continue;
    for (std::uint32_t k = r.first_triangle; k < r.first_triangle + r.triangle_count; ++k) {
      const auto& t = caps.triangles[k];
      twice += length(cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0])));
    }
  }
  return twice / 2;
}

/// Total length of the Voronoi edges that bound wanted caps, counted once per cap; an upper bound.
template <class Wanted>
double length_of_edges(const Winding& winding, const VertexPositions& positions, const Wanted& wanted,
                       const Execution& execution) {
  Pacer pacer(execution);
  double sum = 0;
  for (const CapSegment& s : winding.segments) {
    pacer.step();
    if (wanted(s.lo, s.hi))
      sum += length(positions.points[s.to - positions.first_constructed] -
                    positions.points[s.from - positions.first_constructed]);
  }
  return sum;
}

/// Rounds up to a power of two. Values that depend on all cells are rounded, so that one more cell rarely
/// changes them.
double rounded_up(double length) {
  int exponent = 0;
  const double mantissa = std::frexp(length, &exponent);
  return std::ldexp(1, mantissa == 0.5 ? exponent - 1 : exponent);
}

/// Marks the triangles of all caps that separate two owners.
template <class Parts>
std::vector<char> seen_of(const Caps& caps, const Parts& parts) {
  std::vector<char> seen(caps.triangles.size(), 0);
  for (const CapRegion& r : caps.regions)
    if (parts(r.lo, r.hi))
      std::fill_n(seen.begin() + static_cast<std::ptrdiff_t>(r.first_triangle), r.triangle_count, 1);
  return seen;
}

/// Amplitude and edge length before limits on the number of triangles.
RoughReport asked_of(double size, const Roughness& roughness) {
  RoughReport report;
  report.asked = roughness.amplitude * size;
  report.amplitude = std::fmin(report.asked, kMostSteepness / roughness.frequency * size);
  const double finest = std::ldexp(roughness.frequency / size, static_cast<int>(roughness.octaves) - 1);
  report.length = 1 / (kEdgesPerWave * finest);
  return report;
}

/// The fading zone is visibly rough. Near the surface, where a cut has only the corners of its outline,
/// nothing moves.
Displacement displacement_of(const RoughReport& report, const Roughness& roughness, double size,
                             std::uint64_t seed, const CellMap& map) {
  const double still = std::fmax(0, kOutlineAlone * report.length - Displacement::fading(report.amplitude));
  return {report.amplitude, roughness.frequency / size, roughness.octaves, seed, map, still};
}

/// An equilateral triangle of side l has an area of 0.433 l². Divided edges add vertices. Edges shorter than
/// lattice steps would be rounded away.
double least_length(double area, double edges, const SeamLattice& lattice) {
  const Vec3d step = lattice.step();
  return std::fmax(
      std::sqrt(area / (0.433 * kMostRoughTriangles)),
      std::fmax(edges / kMostRoughTriangles, kLeastSteps * std::fmax(step.x, std::fmax(step.y, step.z))));
}

}  // namespace

std::vector<Movement> movements_of_cuts(const Solid& solid, const Roughness& roughness, const CellMap& map) {
  const double size = size_of(solid);
  const Displacement displacement =
      displacement_of(asked_of(size, roughness), roughness, size, /*seed=*/0, map);
  std::vector<Movement> movements;
  for (std::size_t frame = 0; frame < displacement.frames(); ++frame)
    movements.push_back(displacement.most(frame));
  return movements;
}

RoughReport roughen(RestrictedDiagram& restricted, const std::vector<std::uint32_t>& owner_of_site,
                    const Roughness& roughness, const Restraints& restraints, std::uint64_t seed,
                    const Execution& execution) {
  const Solid& solid = restricted.solid;
  const VoronoiDiagram& diagram = restricted.diagram;
  VertexPositions& positions = restricted.positions;
  Caps& caps = restricted.caps;
  if (!(roughness.amplitude > 0)) return {};
  const auto parts = [&](SiteId lo, SiteId hi) { return owner_of_site[lo] != owner_of_site[hi]; };
  const auto wanted = [&](SiteId lo, SiteId hi) {
    return parts(lo, hi) && restraint_of(restraints, lo, hi) != Restraint::kFlat;
  };
  const auto plain = [&](SiteId lo, SiteId hi) { return parts(lo, hi) && !wanted(lo, hi); };
  const double size = size_of(solid), area = area_of(caps, positions, parts, execution);
  RoughReport report = asked_of(size, roughness);
  if (!(area > 0)) return {.amplitude = report.amplitude, .asked = report.asked};
  const double edges = length_of_edges(restricted.winding, positions, parts, execution);
  const double least = least_length(area, edges, positions.lattice);
  const bool limited = least > report.length;
  if (limited) report.length = rounded_up(least);
  positions.flat_steps = positions.steps;
  refine_caps(diagram, restricted.winding, report.length, {wanted, plain}, caps, positions, execution);
  for (const CapRegion& r : caps.regions)
    if (wanted(r.lo, r.hi)) report.triangles += r.triangle_count;

  const Displacement displacement = displacement_of(report, roughness, size, seed, diagram.map());
  const SurfaceTree outside(corners_of(solid, execution), execution);
  MovingCaps moving(restricted, seen_of(caps, parts), execution);
  if (!restraints.empty()) moving.restrain(restraints);
  moving.move(displacement, outside);
  const std::optional<std::uint64_t> crossing = moving.calm(outside);
  report.crossing = crossing.value_or(0);
  report.given_up = !crossing;
  report.calmed = moving.calmed();
  begin_at_coinciding_corners(positions, caps, execution);
  caps.normals = cap_normals(diagram, owner_of_site, caps, positions, execution);
  return report;
}

}  // namespace fracture
