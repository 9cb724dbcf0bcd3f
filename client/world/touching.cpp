#include "client/world/touching.hpp"

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>

#include <algorithm>
#include <cmath>

#include "client/world/bond_loads.hpp"
#include "client/world/bullet.hpp"

namespace fracture::world {
namespace {

constexpr double kTouch = 0.005;       ///< metres between hulls that touch, at most …
constexpr double kTouchShare = 0.002;  ///< … and of the diagonal of all

struct FragmentBox {
  glm::dvec3 low{HUGE_VAL}, high{-HUGE_VAL};
  void add(const glm::dvec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  bool meets(const FragmentBox& other, double gap) const {
    for (int k = 0; k < 3; ++k)
      if (low[k] > other.high[k] + gap || other.low[k] > high[k] + gap) return false;
    return true;
  }
};

FragmentBox box_of(const Fragment& fragment) {
  FragmentBox box;
  for (const Hull& hull : fragment.hulls)
    for (const glm::dvec3& p : hull) box.add(p);
  return box;
}

double distance(const Hull& a, const Hull& b, double most) {
  // About a's first corner: far from the origin GJK loses digits.
  const auto shape = [&](const Hull& hull) {
    btConvexHullShape made;
    for (const glm::dvec3& p : hull) made.addPoint(to_bullet(p - a.front()), false);
    made.setMargin(0);
    made.recalcLocalAabb();
    return made;
  };
  const btConvexHullShape first = shape(a), second = shape(b);
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth;
  btGjkPairDetector detector(&first, &second, &simplex, &depth);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA.setIdentity();
  input.m_transformB.setIdentity();
  input.m_maximumDistanceSquared = 4 * most * most;
  btPointCollector found;
  detector.getClosestPoints(input, found, nullptr);
  return found.m_hasResult ? found.m_distance : HUGE_VAL;
}

bool touch(const Fragment& a, const Fragment& b, double gap) {
  for (const Hull& first : a.hulls)
    for (const Hull& second : b.hulls)
      if (distance(first, second, gap) <= gap) return true;
  return false;
}

}  // namespace

std::size_t bond_touching_parts(FragmentSet& set) {
  if (set.bonds.empty()) return 0;
  std::vector<std::uint32_t> all_fragments, all_bonds;
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k)
    if (!set.fragments[k].gone) all_fragments.push_back(k);
  for (std::uint32_t k = 0; k < set.bonds.size(); ++k)
    if (!set.bonds[k].gone) all_bonds.push_back(k);
  const auto parts = components(all_fragments, all_bonds, set);
  if (parts.size() < 2) return 0;
  std::vector<std::uint32_t> part_of(set.fragments.size());
  for (std::uint32_t p = 0; p < parts.size(); ++p)
    for (const std::uint32_t m : parts[p]) part_of[m] = p;

  std::vector<double> strengths;
  for (const Bond& bond : set.bonds)
    if (bond.area > 0) strengths.push_back(bond.strength / bond.area);
  if (strengths.empty()) return 0;
  const auto middle = strengths.begin() + static_cast<std::ptrdiff_t>(strengths.size() / 2);
  std::nth_element(strengths.begin(), middle, strengths.end());

  std::vector<FragmentBox> boxes;
  FragmentBox all;
  for (const Fragment& fragment : set.fragments) {
    boxes.push_back(box_of(fragment));
    all.add(boxes.back().low);
    all.add(boxes.back().high);
  }
  const double gap = std::min(kTouch, kTouchShare * glm::length(all.high - all.low));
  std::vector<std::uint32_t> by_x = all_fragments;
  std::stable_sort(by_x.begin(), by_x.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return boxes[a].low.x < boxes[b].low.x; });
  std::vector<Bond> made;
  for (std::size_t i = 0; i < by_x.size(); ++i)
    for (std::size_t j = i + 1; j < by_x.size() && boxes[by_x[j]].low.x <= boxes[by_x[i]].high.x + gap; ++j) {
      const std::uint32_t a = std::min(by_x[i], by_x[j]), b = std::max(by_x[i], by_x[j]);
      const Fragment &first = set.fragments[a], &second = set.fragments[b];
      if (part_of[a] == part_of[b] || !boxes[a].meets(boxes[b], gap) || !touch(first, second, gap)) continue;
      const glm::dvec3 common = glm::max(
          glm::min(boxes[a].high, boxes[b].high) - glm::max(boxes[a].low, boxes[b].low), glm::dvec3(gap));
      const double area = 0.5 * std::max({common.x * common.y, common.y * common.z, common.z * common.x});
      const glm::dvec3 along = second.mass.center - first.mass.center;
      const double length = glm::length(along);
      made.push_back({a, b, area, *middle * area, length > 0 ? along / length : glm::dvec3(0),
                      0.5 * (glm::max(boxes[a].low, boxes[b].low) + glm::min(boxes[a].high, boxes[b].high))});
    }
  std::sort(made.begin(), made.end(),
            [](const Bond& x, const Bond& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  set.bonds.insert(set.bonds.end(), made.begin(), made.end());
  return made.size();
}

}  // namespace fracture::world
