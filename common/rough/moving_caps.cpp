#include "common/rough/moving_caps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/rough/edge_splits.hpp"

namespace fracture {
namespace {

/// Maximum number of rounds of calming. The first rounds leave a quarter of the movement, and each later
/// round none of it.
constexpr std::uint32_t kQuarteringRounds = 2, kMostRounds = 40;
/// Crossings of fewer lattice steps are due to rounding.
constexpr double kLeastCrossing = 8;

}  // namespace

MovingCaps::MovingCaps(RestrictedDiagram& restricted, std::vector<char> seen, const Execution& execution)
    : execution_(execution),
      pacer_(execution),
      diagram_(restricted.diagram),
      caps_(restricted.caps),
      positions_(restricted.positions),
      seen_(std::move(seen)),
      fixed_(restricted.cuts.edge_cuts.size() + restricted.cuts.triangle_cuts.size()),
      flat_(positions_.points),
      moves_(flat_.size()),
      surface_(flat_.size(), 0),
      share_(flat_.size(), 1),
      moved_(flat_.size(), 0) {
  pacer_.each(fixed_, flat_.size(), [&](std::size_t v) {  // coinciding vertices stay together
    flat_[v] = positions_.lattice.to_world(positions_.steps[v]);
  });
  const bool frames = diagram_.map().frames().size() > 1;
  facets_.reserve(caps_.regions.size());
  region_begin_.reserve(caps_.regions.size() + 1);
  for (const CapRegion& r : caps_.regions) {
    pacer_.step(4);
    facets_.push_back(
        {frames ? diagram_.map().index_at(diagram_.site(r.lo)) : 0, diagram_.facet_normal(r.lo, r.hi)});
    region_begin_.push_back(r.first_triangle);
  }
  region_begin_.push_back(static_cast<std::uint32_t>(caps_.triangles.size()));
}

void MovingCaps::restrain(const Restraints& restraints) {
  find_coinciding();
  for (const CapRegion& r : caps_.regions) {
    pacer_.step(8 + r.triangle_count);
    const Restraint restraint = restraint_of(restraints, r.lo, r.hi);
    if (restraint == Restraint::kNone || r.triangle_count == 0 || !seen_[r.first_triangle]) continue;
    const double share = restraint == Restraint::kLess ? kLessAmplitude : 0;
    for (std::uint32_t t = r.first_triangle; t < r.first_triangle + r.triangle_count; ++t)
      for (const CutVertexId id : caps_.triangles[t]) {
        double& of_leader = share_[leader_[number(id)]];
        of_leader = std::fmin(of_leader, share);
      }
  }
  pacer_.each(fixed_, share_.size(), [&](std::size_t v) { share_[v] = share_[leader_[v]]; });
}

void MovingCaps::move(const Displacement& displacement, const SurfaceTree& outside) {
  std::vector<std::uint8_t> frame;  // frame of the map for each vertex; empty if there is at most one
  if (diagram_.map().frames().size() > 1) {
    frame.assign(flat_.size(), 0);
    for (std::size_t r = 0; r < facets_.size(); ++r)
      for (std::uint32_t t = region_begin_[r]; t < region_begin_[r + 1]; ++t) {
        pacer_.step();
        for (const CutVertexId id : caps_.triangles[t])
          if (id >= positions_.first_constructed)
            frame[number(id)] = static_cast<std::uint8_t>(facets_[r].frame);
      }
  }
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

void MovingCaps::place(std::size_t v) {
  const Vec3d p = flat_[v] + share_[v] * moves_[v];
  positions_.points[v] = p;
  positions_.steps[v] = nearest_steps(positions_.lattice, p);
  moved_[v] = share_[v] > 0 && !(moves_[v] == Vec3d{});
}

/// Vertices at the same place under several keys (lattices of sites) move together.
void MovingCaps::find_coinciding() {
  leader_.resize(flat_.size());
  order_.resize(flat_.size());
  pacer_.each(0, leader_.size(),
              [&](std::size_t v) { leader_[v] = order_[v] = static_cast<std::uint32_t>(v); });
  sort_with_polls(execution_, order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (!(flat_[a] == flat_[b])) return lexicographic_less(flat_[a], flat_[b]);
    return is_fixed(a) != is_fixed(b) ? is_fixed(a) : a < b;
  });
  pacer_.each(1, order_.size(), [&](std::size_t k) {
    const std::uint32_t a = order_[k - 1], b = order_[k];
    if (flat_[a] == flat_[b] && is_fixed(a) == is_fixed(b)) leader_[b] = leader_[a];
  });
}

/// Finds triangles that face away from their facet's normal. A triangle no higher than the tolerance has no
/// definite side. It counts only if it faced the right way before it moved, or if its height now exceeds the
/// tolerance. If there are suspects, only they are tested, because the others have not changed.
void MovingCaps::add_turned_over(double tolerance, const std::vector<char>& suspects,
                                 std::vector<char>& bad) {
  for (std::size_t r = 0; r < facets_.size(); ++r) {
    const std::uint32_t begin = region_begin_[r], end = region_begin_[r + 1];
    pacer_.step(8 + end - begin);
    if (begin == end || !seen_[begin]) continue;
    const Vec3d& u = facets_[r].normal;
    for (std::uint32_t t = begin; t < end; ++t) {
      if (!suspects.empty() && !suspects[t]) continue;
      const auto corner = [&](const std::vector<Vec3d>& points, std::size_t k) {
        return points[number(caps_.triangles[t][k % 3])];
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

/// Moves vertices of bad triangles back. Returns whether anything was moved.
bool MovingCaps::calm_round(std::uint32_t round, const std::vector<char>& bad, std::vector<char>& calmed) {
  calmed.assign(flat_.size(), 0);
  pacer_.each(0, bad.size(), [&](std::size_t t) {
    if (bad[t])
      for (const CutVertexId id : caps_.triangles[t])
        if (const std::size_t v = number(id); moved_[v]) calmed[leader_[v]] = 1;
  });
  bool any = false;
  pacer_.each(fixed_, flat_.size(), [&](std::size_t v) {
    if (!calmed[leader_[v]]) return;
    calmed[v] = 1;
    any = true;
    share_[v] = round < kQuarteringRounds ? 0.25 * share_[v] : 0;
    place(v);
  });
  return any;
}

std::optional<std::uint64_t> MovingCaps::calm(const SurfaceTree& outside) {
  find_coinciding();
  const Vec3d step = positions_.lattice.step();
  const double tolerance = kLeastCrossing * std::fmax(step.x, std::fmax(step.y, step.z));
  Crossings crossings({caps_.triangles, region_begin_, seen_, positions_.first_constructed, positions_.points,
                       flat_, moved_, surface_, leader_},
                      outside, tolerance, execution_);
  std::vector<char> suspects, bad, calmed;
  std::optional<std::uint64_t> crossing = 0;
  for (std::uint32_t round = 0; round < kMostRounds; ++round) {
    crossing = crossings.find(suspects, bad, execution_);
    if (!crossing) {
      pacer_.each(fixed_, flat_.size(), [&](std::size_t v) {
        share_[v] = 0;
        place(v);
      });
      break;
    }
    add_turned_over(tolerance, suspects, bad);
    if (!calm_round(round, bad, calmed)) break;
    suspects.assign(caps_.triangles.size(), 0);
    pacer_.each(0, suspects.size(), [&](std::size_t t) {
      for (const CutVertexId id : caps_.triangles[t]) suspects[t] |= calmed[number(id)];
    });
  }
  return crossing;
}

std::uint64_t MovingCaps::calmed() const {
  std::uint64_t places = 0;
  for (std::size_t v = fixed_; v < flat_.size(); ++v) places += leader_[v] == v && share_[v] < 1;
  return places;
}

}  // namespace fracture
