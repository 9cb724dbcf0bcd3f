#include "common/physics/convex_body.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/id.hpp"

namespace fracture {

void ConvexBody::set(std::span<const Vec3f> points, std::span<const std::array<std::uint32_t, 3>> triangles) {
  number_.assign(points.size(), kNoIndex);
  points_.clear();
  corners_.clear();
  begin_.assign(1, 0);
  for (const auto& t : triangles) {
    for (const std::uint32_t v : t) {
      if (number_[v] == kNoIndex) {
        number_[v] = static_cast<std::uint32_t>(points_.size());
        points_.push_back(to_double(points[v]));
      }
      corners_.push_back(number_[v]);
    }
    begin_.push_back(static_cast<std::uint32_t>(corners_.size()));
  }
}

double ConvexBody::beyond(const Vec3d& normal, double offset) const {
  double most = -HUGE_VAL;
  for (const Vec3d& p : points_) most = std::max(most, dot(normal, p) - offset);
  return most;
}

std::uint32_t ConvexBody::cut_edge(std::uint32_t kept, std::uint32_t gone, double rounding) {
  if (height_[kept] >= -rounding) return kept;
  const std::uint32_t lo = std::min(kept, gone), hi = std::max(kept, gone);
  for (const Made& m : made_)
    if (m.lo == lo && m.hi == hi) return m.corner;
  const double t = height_[lo] / (height_[lo] - height_[hi]);
  const auto corner = static_cast<std::uint32_t>(points_.size());
  points_.push_back(points_[lo] + t * (points_[hi] - points_[lo]));
  made_.push_back({lo, hi, corner});
  return corner;
}

void ConvexBody::cut(const Vec3d& normal, double offset, double rounding) {
  height_.clear();
  bool any = false;
  for (const Vec3d& p : points_) {
    height_.push_back(dot(normal, p) - offset);
    any = any || height_.back() > rounding;
  }
  if (!any) return;
  const auto is_kept = [&](std::uint32_t v) { return height_[v] <= rounding; };
  const std::size_t before = points_.size();
  made_.clear();
  new_corners_.clear();
  new_begin_.assign(1, 0);
  next_.assign(before, kNoIndex);
  const auto end_face = [&] {  // a face with only two corners is an edge on the plane
    if (new_corners_.size() > new_begin_.back() + 2)
      new_begin_.push_back(static_cast<std::uint32_t>(new_corners_.size()));
    else
      new_corners_.resize(new_begin_.back());
  };
  for (std::size_t f = 0; f + 1 < begin_.size(); ++f) {
    const std::uint32_t first = begin_[f], last = begin_[f + 1];
    std::uint32_t left = kNoIndex, first_entered = kNoIndex;  // crossings out of the kept part, and into it
    const auto close = [&](std::uint32_t entered) {
      if (entered == left) return;  // the face has only a corner on the plane
      if (next_.size() <= entered) next_.resize(entered + 1, kNoIndex);
      next_[entered] = left;
    };
    for (std::uint32_t k = first; k < last; ++k) {
      const std::uint32_t a = corners_[k], b = corners_[k + 1 < last ? k + 1 : first];
      if (is_kept(a)) new_corners_.push_back(a);
      if (is_kept(a) == is_kept(b)) continue;
      const std::uint32_t x = is_kept(a) ? cut_edge(a, b, rounding) : cut_edge(b, a, rounding);
      if (x >= before) new_corners_.push_back(x);
      if (is_kept(a))
        left = x;
      else if (left != kNoIndex)
        close(x);
      else
        first_entered = x;
    }
    if (first_entered != kNoIndex) close(first_entered);
    end_face();
  }
  // The face of the cut runs along the rim, in the direction opposite to the other faces.
  next_.resize(points_.size(), kNoIndex);
  for (std::uint32_t start = 0; start < next_.size(); ++start) {
    for (std::uint32_t v = start; next_[v] != kNoIndex;) {
      new_corners_.push_back(v);
      const std::uint32_t following = next_[v];
      next_[v] = kNoIndex;
      v = following;
    }
    end_face();
  }
  // Removes unused corners.
  number_.assign(points_.size(), kNoIndex);
  for (const std::uint32_t v : new_corners_) number_[v] = 0;
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < points_.size(); ++v)
    if (number_[v] == 0) {
      number_[v] = static_cast<std::uint32_t>(count);
      points_[count++] = points_[v];
    }
  points_.resize(count);
  for (std::uint32_t& v : new_corners_) v = number_[v];
  corners_.swap(new_corners_);
  begin_.swap(new_begin_);
}

void ConvexBody::write(std::vector<Vec3f>& points,
                       std::vector<std::array<std::uint32_t, 3>>& triangles) const {
  points.clear();
  triangles.clear();
  for (const Vec3d& p : points_)
    points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  for (std::size_t f = 0; f + 1 < begin_.size(); ++f)
    for (std::uint32_t k = begin_[f] + 2; k < begin_[f + 1]; ++k)
      triangles.push_back({corners_[begin_[f]], corners_[k - 1], corners_[k]});
}

}  // namespace fracture
