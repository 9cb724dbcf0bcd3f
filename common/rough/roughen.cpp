#include "common/rough/roughen.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/pacer.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/rough/cap_normals.hpp"
#include "common/rough/crossings.hpp"
#include "common/rough/displacement.hpp"
#include "common/rough/edge_splits.hpp"
#include "common/rough/refine.hpp"
#include "common/solid/corners.hpp"

namespace fracture {
namespace {

/// Rounds of calming: each of the first leaves a quarter of the movement, each later one nothing of it.
constexpr int kQuarteringRounds = 2, kMostRounds = 40;
/// Edges are no shorter than so many lattice steps.
constexpr double kLeastSteps = 32;
/// Crossings of fewer lattice steps are rounding.
constexpr double kLeastCrossing = 8;

/// By Newton's iteration, from + * / alone: the C library's cbrt is not rounded alike everywhere.
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

/// Of the pieces of Voronoi edges that wanted caps share, each as often as it has caps: at least its length.
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

/// The least power of two that is no less: what depends on all cells is rounded, so that a further cell
/// seldom changes it.
double rounded_up(double length) {
  int exponent = 0;
  const double mantissa = std::frexp(length, &exponent);
  return std::ldexp(1, mantissa == 0.5 ? exponent - 1 : exponent);
}

/// Moves the vertices, and those less that make triangles cross or turn over.
class Mover {
 public:
  /// `seen`: per triangle; those inside a fragment are no cuts and in nobody's way.
  Mover(const VoronoiDiagram& diagram, const Caps& caps, const std::vector<char>& seen,
        VertexPositions& positions, std::size_t fixed, const Execution& execution)
      : execution_(execution),
        pacer_(execution),
        diagram_(diagram),
        caps_(caps),
        seen_(seen),
        positions_(positions),
        fixed_(fixed),
        flat_(positions.points),
        moves_(flat_.size()),
        surface_(flat_.size(), 0),
        share_(flat_.size(), 1),
        moved_(flat_.size(), 0) {
    pacer_.each(fixed_, flat_.size(), [&](std::size_t v) {  // coinciding vertices stay together
      flat_[v] = positions_.lattice.to_world(positions_.steps[v]);
    });
  }

  /// Before move(): vertices of restrained caps get their share of the movement.
  void restrain(const Restraints& restraints) {
    find_coinciding();
    for (const CapRegion& r : caps_.regions) {
      pacer_.step(8 + r.triangle_count);
      const Restraint restraint = restraint_of(restraints, r.lo, r.hi);
      if (restraint == Restraint::kNone || r.triangle_count == 0 || !seen_[r.first_triangle]) continue;
      const double share = restraint == Restraint::kLess ? kLessAmplitude : 0;
      for (std::uint32_t t = r.first_triangle; t < r.first_triangle + r.triangle_count; ++t)
        for (const CutVertexId id : caps_.triangles[t]) {
          double& of_leader = share_[leader_[id - positions_.first_constructed]];
          of_leader = std::fmin(of_leader, share);
        }
    }
    pacer_.each(fixed_, share_.size(), [&](std::size_t v) { share_[v] = share_[leader_[v]]; });
  }

  void move(const Displacement& displacement, const SurfaceTree& outside) {
    const std::vector<std::uint8_t> frame = frames();
    parallel_for(execution_, flat_.size() - fixed_, 256, [&](std::size_t begin, std::size_t end) {
      Pacer pacer(execution_);
      outside.distances({flat_.data() + fixed_ + begin, end - begin}, displacement.reach(),
                        {surface_.data() + fixed_ + begin, end - begin}, pacer);
      for (std::size_t v = fixed_ + begin; v < fixed_ + end; ++v) {
        pacer.step(4);
        moves_[v] = displacement.at(flat_[v], surface_[v], frame.empty() ? 0 : frame[v]);
        place(v);
      }
    });
  }

  /// Returns how many pairs of triangles cross at the end; nothing where too many would have to be looked at:
  /// then everything is back in its place.
  std::optional<std::uint64_t> calm(const SurfaceTree& outside) {
    find_coinciding();
    const Vec3d step = positions_.lattice.step();
    const double tolerance = kLeastCrossing * std::fmax(step.x, std::fmax(step.y, step.z));
    std::vector<std::uint32_t> region_begin;
    for (const CapRegion& region : caps_.regions) region_begin.push_back(region.first_triangle);
    region_begin.push_back(static_cast<std::uint32_t>(caps_.triangles.size()));
    Crossings crossings({caps_.triangles, region_begin, seen_, positions_.first_constructed,
                         positions_.points, flat_, moved_, surface_},
                        outside, tolerance, execution_);
    std::vector<char> suspects, bad;
    std::optional<std::uint64_t> pairs = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      pairs = crossings.find(suspects, bad, execution_);
      if (!pairs) {
        pacer_.each(fixed_, flat_.size(), [&](std::size_t v) {
          share_[v] = 0;
          place(v);
        });
        break;
      }
      add_turned_over(tolerance, bad);
      std::vector<char> calmed(flat_.size(), 0);
      pacer_.each(0, bad.size(), [&](std::size_t t) {
        if (bad[t])
          for (const CutVertexId id : caps_.triangles[t])
            if (const std::size_t v = id - positions_.first_constructed; moved_[v]) calmed[leader_[v]] = 1;
      });
      bool any = false;
      pacer_.each(fixed_, flat_.size(), [&](std::size_t v) {
        if (!calmed[leader_[v]]) return;
        calmed[v] = 1;
        any = true;
        share_[v] = round < kQuarteringRounds ? 0.25 * share_[v] : 0;
        place(v);
      });
      if (!any) break;
      suspects.assign(caps_.triangles.size(), 0);
      pacer_.each(0, suspects.size(), [&](std::size_t t) {
        for (const CutVertexId id : caps_.triangles[t])
          suspects[t] |= calmed[id - positions_.first_constructed];
      });
    }
    return pairs;
  }

  std::uint64_t calmed() const {
    return static_cast<std::uint64_t>(
        std::count_if(share_.begin(), share_.end(), [](double s) { return s < 1; }));
  }

 private:
  /// Of the map, for each vertex; empty where it has one at most.
  std::vector<std::uint8_t> frames() {
    std::vector<std::uint8_t> frame;
    if (diagram_.map().frames().size() < 2) return frame;
    frame.assign(flat_.size(), 0);
    for (const CapRegion& r : caps_.regions) {
      pacer_.step(1 + r.triangle_count);
      const auto index = static_cast<std::uint8_t>(diagram_.map().index_at(diagram_.site(r.lo)));
      for (std::uint32_t t = r.first_triangle; t < r.first_triangle + r.triangle_count; ++t)
        for (const CutVertexId id : caps_.triangles[t])
          if (id >= positions_.first_constructed) frame[id - positions_.first_constructed] = index;
    }
    return frame;
  }

  void place(std::size_t v) {
    const Vec3d step = positions_.lattice.step();
    const Vec3d p = flat_[v] + share_[v] * moves_[v];
    positions_.points[v] = p;
    for (int a = 0; a < 3; ++a)
      positions_.steps[v][static_cast<std::size_t>(a)] =
          static_cast<std::int32_t>(std::nearbyint(p[a] / step[a]));
    moved_[v] = share_[v] > 0 && !(moves_[v] == Vec3d{});
  }

  /// Vertices at the same place under several keys (lattices of sites) stay together.
  void find_coinciding() {
    leader_.resize(flat_.size());
    std::vector<std::uint32_t> order;
    order.reserve(flat_.size() - fixed_);
    pacer_.each(0, leader_.size(), [&](std::size_t n) {
      const auto v = static_cast<std::uint32_t>(n);
      leader_[v] = v;
      if (v >= fixed_) order.push_back(v);
    });
    sort_with_polls(execution_, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return flat_[a] == flat_[b] ? a < b : lexicographic_less(flat_[a], flat_[b]);
    });
    pacer_.each(1, order.size(), [&](std::size_t k) {
      if (flat_[order[k]] == flat_[order[k - 1]]) leader_[order[k]] = leader_[order[k - 1]];
    });
  }

  /// Triangles that face away from their facet's normal. Those that are no higher than the tolerance have no side:
  /// such a one counts where it faced the right way when it was flat, or is higher now.
  void add_turned_over(double tolerance, std::vector<char>& bad) {
    for (const CapRegion& region : caps_.regions) {
      pacer_.step(8 + region.triangle_count);
      if (region.triangle_count == 0 || !seen_[region.first_triangle]) continue;
      const Vec3d u = diagram_.facet_normal(region.lo, region.hi);
      for (std::uint32_t t = region.first_triangle; t < region.first_triangle + region.triangle_count; ++t) {
        const auto corner = [&](const std::vector<Vec3d>& points, std::size_t k) {
          return points[caps_.triangles[t][k % 3] - positions_.first_constructed];
        };
        const auto facing = [&](const std::vector<Vec3d>& points) {
          return dot(u, cross(corner(points, 1) - corner(points, 0), corner(points, 2) - corner(points, 0)));
        };
        const auto least = [&](const std::vector<Vec3d>& points) {
          double longest = 0;
          for (std::size_t k = 0; k < 3; ++k)
            longest = std::fmax(longest, length(corner(points, k + 1) - corner(points, k)));
          return tolerance * longest * length(u);
        };
        const double now = facing(positions_.points);
        if (now > 0) continue;
        if (facing(flat_) > least(flat_) || now < -least(positions_.points)) bad[t] = 1;
      }
    }
  }

  const Execution& execution_;
  Pacer pacer_;
  const VoronoiDiagram& diagram_;
  const Caps& caps_;
  const std::vector<char>& seen_;
  VertexPositions& positions_;
  const std::size_t fixed_;  // the vertices before are on the surface
  // Per constructed vertex.
  std::vector<Vec3d> flat_;
  std::vector<Vec3d> moves_;
  std::vector<double> surface_;  // distance, up to the reach of fading
  std::vector<double> share_;    // of the movement
  std::vector<char> moved_;
  std::vector<std::uint32_t> leader_;  // the lowest vertex at the same place
};

}  // namespace

RoughReport roughen(RestrictedDiagram& restricted, const std::vector<std::uint32_t>& owner_of_site,
                    const Roughness& roughness, const Restraints& restraints, std::uint64_t seed,
                    const Execution& execution) {
  const Solid& solid = restricted.solid;
  const VoronoiDiagram& diagram = restricted.diagram;
  const Winding& winding = restricted.winding;
  VertexPositions& positions = restricted.positions;
  Caps& caps = restricted.caps;
  RoughReport report;
  if (!(roughness.amplitude > 0)) return report;
  const auto parts = [&](SiteId lo, SiteId hi) { return owner_of_site[lo] != owner_of_site[hi]; };
  const auto wanted = [&](SiteId lo, SiteId hi) {
    return parts(lo, hi) && restraint_of(restraints, lo, hi) != Restraint::kFlat;
  };
  const auto plain = [&](SiteId lo, SiteId hi) { return parts(lo, hi) && !wanted(lo, hi); };
  const double size = size_of(solid), area = area_of(caps, positions, parts, execution);
  report.asked = roughness.amplitude * size;
  report.amplitude = std::fmin(report.asked, kMostSteepness / roughness.frequency * size);
  if (!(area > 0)) return report;
  const double finest = std::ldexp(roughness.frequency / size, static_cast<int>(roughness.octaves) - 1);
  report.length = 1 / (kEdgesPerWave * finest);
  // An equilateral triangle of side l has 0.433 l² of area; edges have ends of their own; and what is shorter
  // than the lattice is rounded away.
  const Vec3d step = positions.lattice.step();
  const double least =
      std::fmax(std::sqrt(area / (0.433 * kMostRoughTriangles)),
                std::fmax(length_of_edges(winding, positions, parts, execution) / kMostRoughTriangles,
                          kLeastSteps * std::fmax(step.x, std::fmax(step.y, step.z))));
  if (least > report.length) report.length = rounded_up(least);
  positions.flat_steps = positions.steps;
  refine_caps(diagram, winding, report.length, {wanted, plain}, caps, positions, execution);
  for (const CapRegion& r : caps.regions)
    if (wanted(r.lo, r.hi)) report.triangles += r.triangle_count;

  const Displacement displacement(report.amplitude, roughness.frequency / size, roughness.octaves, seed,
                                  diagram.map());
  const SurfaceTree outside(corners_of(solid, execution), execution);
  std::vector<char> seen(caps.triangles.size(), 0);
  for (const CapRegion& r : caps.regions)
    if (parts(r.lo, r.hi))
      std::fill_n(seen.begin() + static_cast<std::ptrdiff_t>(r.first_triangle), r.triangle_count, 1);
  Mover mover(diagram, caps, seen, positions,
              restricted.cuts.edge_cuts.size() + restricted.cuts.triangle_cuts.size(), execution);
  if (!restraints.empty()) mover.restrain(restraints);
  mover.move(displacement, outside);
  const std::optional<std::uint64_t> crossing = mover.calm(outside);
  report.crossing = crossing.value_or(0);
  report.given_up = !crossing;
  report.calmed = mover.calmed();
  begin_at_coinciding_corners(positions, caps, execution);
  caps.normals = cap_normals(diagram, owner_of_site, caps, positions, execution);
  return report;
}

}  // namespace fracture
