#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <cmath>

#include "client/world/bullet.hpp"

namespace fracture::world {
namespace {

constexpr double kMargin = 0.002;      ///< metres, for hulls thick enough for it
constexpr double kMarginShare = 0.04;  ///< of the shortest side of the hull's box
/// Direction k of n directions spread evenly over the sphere (a Fibonacci lattice).
glm::dvec3 spread_direction(std::size_t k, std::size_t n) {
  const double golden = 3.14159265358979323846 * (3 - std::sqrt(5.0));
  const double y = 1 - 2 * (static_cast<double>(k) + 0.5) / static_cast<double>(n);
  const double r = std::sqrt(1 - y * y), angle = golden * static_cast<double>(k);
  return {r * std::cos(angle), y, r * std::sin(angle)};
}

template <class Points>
std::size_t farthest(const Points& points, const glm::dvec3& direction) {
  std::size_t best = 0;
  double far = -HUGE_VAL;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double d = glm::dot(direction, glm::dvec3(points[p]));
    if (d > far) {
      far = d;
      best = p;
    }
  }
  return best;
}

/// The hull's corners after its sides were moved inwards by the margin. A corner with many sides becomes a
/// cluster of corners, of which one is enough (Bullet examines every point in every iteration of GJK). A
/// sharp corner would move inwards by much more than the margin and later sink into the ground by that
/// distance. So it moves only by the margin.
Hull inner_corners(std::span<const glm::dvec3> points, const btConvexHullComputer& inside, double margin) {
  constexpr double kMostMargins = 2.5;
  Hull corners;
  std::vector<bool> taken(static_cast<std::size_t>(inside.vertices.size()));
  for (const glm::dvec3& corner : points) {
    double least = HUGE_VAL;
    int nearest = 0;
    for (int k = 0; k < inside.vertices.size(); ++k) {
      const double d = glm::distance(corner, from_bullet(inside.vertices[k]));
      if (d < least) {
        least = d;
        nearest = k;
      }
    }
    const glm::dvec3 moved = from_bullet(inside.vertices[nearest]);
    if (least > kMostMargins * margin) {
      corners.push_back(corner + margin / least * (moved - corner));
    } else if (!taken[static_cast<std::size_t>(nearest)]) {
      taken[static_cast<std::size_t>(nearest)] = true;
      corners.push_back(moved);
    }
  }
  return corners;
}

}  // namespace

std::unique_ptr<HullShape> make_hull(std::span<const glm::dvec3> points) {
  glm::dvec3 low(HUGE_VAL), high(-HUGE_VAL);
  for (const glm::dvec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::dvec3 size = high - low;
  const double margin = std::min(kMargin, kMarginShare * std::min({size.x, size.y, size.z}));
  btConvexHullComputer computer;
  const btScalar shrunk = computer.compute(&points[0].x, static_cast<int>(sizeof(glm::dvec3)),
                                           static_cast<int>(points.size()), margin, 0.5);
  auto shape = std::make_unique<HullShape>();
  // A flat hull cannot be shrunk, so it keeps its points.
  const bool usable = shrunk >= 0 && computer.vertices.size() >= 4;
  const Hull corners = usable ? inner_corners(points, computer, margin) : Hull(points.begin(), points.end());
  for (const glm::dvec3& p : corners) shape->addPoint(to_bullet(p), false);
  shape->setMargin(std::max(margin, 1e-5));
  shape->finish();
  return shape;
}

namespace {

PreparedFragments::Part part_of(const Fragment& fragment) {
  const PrincipalAxes axes = principal_axes(fragment.mass.inertia);
  PreparedFragments::Part part;
  part.frame = {fragment.mass.center, axes.rotation};
  part.moments = axes.moments;
  for (const Hull& hull : fragment.hulls) {
    Hull local;
    local.reserve(hull.size());
    for (const glm::dvec3& p : hull) local.push_back(part.frame.local(p));
    part.hulls.push_back(make_hull(local));
  }
  return part;
}

}  // namespace

std::shared_ptr<const PreparedFragments> prepare(FragmentSet set) {
  auto prepared = std::make_shared<PreparedFragments>();
  for (const Fragment& fragment : set.fragments) {
    prepared->parts.push_back(part_of(fragment));
    prepared->volume += fragment.volume;
  }
  prepared->set = std::move(set);
  return prepared;
}

Expected<std::shared_ptr<const PreparedFragments>> prepare(
    const std::shared_ptr<const PreparedFragments>& before, FragmentChange change) {
  Expected<ChangedFragments> changed = apply_change(before->set, std::move(change));
  if (!changed) return tl::unexpected(changed.error());
  auto prepared = std::make_shared<PreparedFragments>();
  prepared->before = before;
  prepared->volume = before->volume;
  prepared->parts = before->parts;
  prepared->parts.resize(changed->set.fragments.size());
  for (const std::uint32_t k : changed->made) prepared->parts[k] = part_of(changed->set.fragments[k]);
  static_cast<ChangedFragments&>(*prepared) = std::move(*changed);
  return prepared;
}

const FragmentSet& fragments_of(const PreparedFragments& prepared) { return prepared.set; }

bool is_replaced(const PreparedFragments& prepared, std::uint32_t fragment) {
  return std::binary_search(prepared.replaced.begin(), prepared.replaced.end(), fragment);
}

Hull reduced_hull(std::span<const glm::vec3> points, std::size_t most) {
  // The farthest points in evenly spread directions (a Fibonacci sphere), all of them corners of the hull.
  Hull hull;
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < 8 * most && !points.empty(); ++k) {
    const std::size_t best = farthest(points, spread_direction(k, 8 * most));
    if (std::find(chosen.begin(), chosen.end(), best) == chosen.end()) chosen.push_back(best);
  }
  // Keeps the points that are farthest from one another.
  while (chosen.size() > most) {
    std::size_t closest = 0;
    double least = HUGE_VAL;
    for (std::size_t a = 0; a < chosen.size(); ++a)
      for (std::size_t b = a + 1; b < chosen.size(); ++b) {
        const double d = glm::distance(glm::dvec3(points[chosen[a]]), glm::dvec3(points[chosen[b]]));
        if (d < least) {
          least = d;
          closest = b;
        }
      }
    chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(closest));
  }
  for (const std::size_t p : chosen) hull.emplace_back(points[p]);
  return hull;
}

}  // namespace fracture::world
