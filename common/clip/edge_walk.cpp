#include "common/clip/edge_walk.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/exact/side.hpp"

namespace fracture {

void EdgeWalk::cut(std::uint32_t e, std::vector<EdgeCut>& cuts) {
  pacer_.step();
  const auto [lo, hi] = solid_.edge_vertices[e];
  a_ = to_double(solid_.positions[lo]);
  b_ = to_double(solid_.positions[hi]);
  for (SiteId cell = label_[lo]; cell != label_[hi];) {
    const SiteId next = diagram_.has_many_neighbors(cell) ? first_by_search(cell) : first_of_all(cell);
    if (next == kNoSite || diagram_.dual().is_corner(next))
      throw InternalError("edge " + std::to_string(e) + " does not leave cell " + std::to_string(cell));
    cuts.push_back({e, cell, next});
    cell = next;
  }
}

/// The value of the bisector of `of` at the crossing `at` (at b if its bisector is null), times a positive
/// factor that depends only on `at`. The crossing is (at_a b - at_b a) / (at_a - at_b). The error of each of
/// these values is at most its bisector's error.
Certified EdgeWalk::value(const Exit& of, const Exit& at) {
  const double error = of.bisector->error;
  if (!at.bisector) return {of.at_b, error};
  const double p = at.at_a * of.at_b, q = at.at_b * of.at_a;
  const double at_error = at.bisector->error;
  return {p - q, 1.001 * (at_error * (std::fabs(of.at_a) + std::fabs(of.at_b)) +
                          error * (std::fabs(at.at_a) + std::fabs(at.at_b)) + 2 * error * at_error) +
                     0x1.0p-50 * (std::fabs(p) + std::fabs(q)) + 1e-300};
}

/// The side of the bisector of `of` on which the crossing `at` is: 1 inside, -1 beyond, 0 uncertain.
int EdgeWalk::certain_side(const Exit& of, const Exit& at) {
  const Certified v = value(of, at);
  return v.value > v.error ? 1 : v.value < -v.error ? -1 : 0;
}

int EdgeWalk::exact_side(SiteId cell, const Exit& of, const Exit& at) const {
  const Vec3d &i = diagram_.site(cell), &j = diagram_.site(of.bisector->neighbor);
  return at.bisector ? exact::side2(i, j, a_, b_, diagram_.site(at.bisector->neighbor))
                     : exact::side1(i, j, b_);
}

// The edge leaves the cell where it first crosses a bisector that b is beyond. This is the crossing that is
// inside all other bisectors.
SiteId EdgeWalk::first_of_all(SiteId cell) {
  const auto bisectors = diagram_.bisectors(cell);
  pacer_.step(2 * bisectors.size());
  Exit first;
  for (const Bisector& bisector : bisectors) {
    if (diagram_.side(cell, bisector, b_) > 0) continue;
    const Exit exit = exit_of(cell, bisector);
    if (first.bisector) {
      int side = certain_side(exit, first);
      if (side == 0) side = exact_side(cell, exit, first);
      if (side > 0) continue;
    }
    first = exit;
  }
  return first.bisector ? first.bisector->neighbor : kNoSite;
}

// For a cell with many neighbours. Starts at b, and moves back to the crossing with the bisector through
// which the ray from the site leaves the cell. Repeats this until the crossing is inside all bisectors.
SiteId EdgeWalk::first_by_search(SiteId cell) {
  const Neighborhood& neighborhood = diagram_.neighborhood(cell);
  const auto bisectors = diagram_.bisectors(cell);
  if (ray_cell_ != cell) ray_ = 0;
  ray_cell_ = cell;
  Exit at;
  for (;;) {
    std::uint64_t looked_at = 1;
    const std::uint32_t on = ray_;  // index of the bisector that contains the crossing
    const auto answer = neighborhood.shoot_ray(
        bisectors, [&](const Bisector& b) { return value(exit_of(cell, b), at); },
        std::span<const std::uint32_t>(&on, at.bisector ? 1 : 0), ray_, looked_at);
    pacer_.step(2 * looked_at);
    Exit next;
    if (answer == Neighborhood::RayAnswer::kOutside)
      next = exit_of(cell, bisectors[ray_]);
    else if (answer == Neighborhood::RayAnswer::kUncertain)
      next = earlier_by_tree(cell, at);
    if (!next.bisector) return at.bisector ? at.bisector->neighbor : kNoSite;
    at = next;
    ray_ = static_cast<std::uint32_t>(at.bisector - bisectors.data());
  }
}

/// A bisector that the edge crosses before `at`; null if there is none.
EdgeWalk::Exit EdgeWalk::earlier_by_tree(SiteId cell, const Exit& at) {
  const auto norm1 = [](const Vec3d& v) { return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z); };
  Vec3d place = b_;
  double off = 0;
  if (at.bisector) {
    // The error of the parameter is at most 2 error / (difference - 2 error), plus a few roundings.
    const Vec3d along = b_ - a_;
    const double difference = at.at_a - at.at_b, error = at.bisector->error;
    off = HUGE_VAL;
    if (difference > 4 * error) {
      place = a_ + (at.at_a / difference) * along;
      off = norm1(along) * (4 * error / difference + 0x1.0p-50) + 0x1.0p-50 * norm1(a_);
    }
  }
  Exit next;
  doubts_.clear();
  double radius2 = diagram_.reach2(cell, place, off);
  diagram_.visit_near(cell, place, radius2, [&](const Bisector& bisector, double distance2) {
    pacer_.step();
    if (at.bisector && bisector.neighbor == at.bisector->neighbor) return radius2;
    const Exit exit = exit_of(cell, bisector);
    const int side = certain_side(exit, at);
    if (side == 0) doubts_.push_back(exit);
    if (side < 0) {
      next = exit;
      radius2 = std::min(radius2, distance2);
    }
    return radius2;
  });
  for (std::size_t k = 0; k < doubts_.size() && !next.bisector; ++k) {
    pacer_.step(16);
    if (exact_side(cell, doubts_[k], at) < 0) next = doubts_[k];
  }
  return next;
}

}  // namespace fracture
