#include "client/world/hull_shape.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace fracture::world {
namespace {

/// Relative to the largest coordinate times the sum of the direction's components: twice the rounding error
/// of a scalar product of floats. Each factor, product and sum is off by at most 2⁻²⁴, in total 5 · 2⁻²⁴, and
/// both sides of a comparison are off.
constexpr float kUnsure = 7e-7F;
/// For shorter directions, floats would lose digits to underflow.
constexpr btScalar kShortest = 1e-20, kLongest = 1e20;

}  // namespace

void HullShape::finish() {
  recalcLocalAabb();
  reach_ = btConvexHullShape::getAngularMotionDisc();
  largest_ = 0;
  const std::size_t count = static_cast<std::size_t>(getNumPoints()), fours = (count + 3) / 4;
  fours_.assign(fours <= kMostFours ? fours : 0, Corners{});
  const btVector3* const points = getUnscaledPoints();
  for (std::size_t k = 0; k < 4 * fours_.size(); ++k) {
    const btVector3& p = points[std::min(k, count - 1)];
    Corners& corners = fours_[k / 4];
    corners.x[k % 4] = static_cast<float>(p.x());
    corners.y[k % 4] = static_cast<float>(p.y());
    corners.z[k % 4] = static_cast<float>(p.z());
    largest_ = std::max({largest_, std::abs(p.x()), std::abs(p.y()), std::abs(p.z())});
  }
}

int HullShape::farthest_of_all(const btVector3& direction) const {
  const btVector3* const points = getUnscaledPoints();
  btScalar most = -SIMD_INFINITY;
  int best = 0;
  for (int k = 0; k < getNumPoints(); ++k)
    if (const btScalar along = points[k].dot(direction); along > most) {
      most = along;
      best = k;
    }
  return best;
}

btVector3 HullShape::localGetSupportingVertexWithoutMargin(const btVector3& direction) const {
  const btVector3* const points = getUnscaledPoints();
  const btScalar size = std::abs(direction.x()) + std::abs(direction.y()) + std::abs(direction.z());
  if (fours_.empty() || !(size > kShortest && size < kLongest)) return points[farthest_of_all(direction)];
  const auto x = static_cast<float>(direction.x()), y = static_cast<float>(direction.y()),
             z = static_cast<float>(direction.z());
  std::array<Four, kMostFours> along;
  Four most = along[0] = fours_[0].x * x + fours_[0].y * y + fours_[0].z * z;
  for (std::size_t k = 1; k < fours_.size(); ++k) {
    const Four value = fours_[k].x * x + fours_[k].y * y + fours_[k].z * z;
    along[k] = value;
    most = value > most ? value : most;
  }
  const float sure = std::max(std::max(most[0], most[1]), std::max(most[2], most[3])) -
                     kUnsure * static_cast<float>(largest_ * size);
  btScalar farthest = -SIMD_INFINITY;
  int best = 0;
  const int count = getNumPoints();
  for (std::size_t k = 0; k < fours_.size(); ++k) {
    using Bits = int __attribute__((vector_size(16)));
    using Halves = long long __attribute__((vector_size(16)));
    const auto near = reinterpret_cast<Halves>(static_cast<Bits>(along[k] >= sure));
    if ((near[0] | near[1]) == 0) continue;
    for (int c = 0; c < 4; ++c) {
      const int corner = static_cast<int>(4 * k) + c;
      if (!(along[k][c] >= sure) || corner >= count) continue;
      if (const btScalar exact = points[corner].dot(direction); exact > farthest) {
        farthest = exact;
        best = corner;
      }
    }
  }
  return points[best];
}

}  // namespace fracture::world
