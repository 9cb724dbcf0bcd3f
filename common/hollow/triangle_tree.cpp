#include "common/hollow/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace fracture::hollow_detail {
namespace {

double squared(const Vec3d& v) { return dot(v, v); }

double squared_distance(const Vec3d& p, const Box& box) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double off = std::fmax(std::fmax(box.min[k] - p[k], p[k] - box.max[k]), 0);
    sum += off * off;
  }
  return sum;
}

Vec3d middle(const Corners& t) { return (1.0 / 3) * (t[0] + t[1] + t[2]); }

}  // namespace

double squared_distance(const Vec3d& p, const Corners& triangle) {
  const auto& [a, b, c] = triangle;
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return squared(ap);
  const Vec3d bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return squared(bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return squared(ap - (d1 / (d1 - d3)) * ab);
  const Vec3d cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return squared(cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return squared(ap - (d2 / (d2 - d6)) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return squared(bp - ((d4 - d3) / (d4 - d3 + (d5 - d6))) * (c - b));
  const double sum = va + vb + vc;
  if (!(sum > 0))
    return std::fmin(squared(ap), std::fmin(squared(bp), squared(cp)));  // a triangle without area
  return squared(ap - (vb / sum) * ab - (vc / sum) * ac);
}

TriangleTree::TriangleTree(std::vector<Corners> triangles, const Execution& execution)
    : triangles_(std::move(triangles)) {
  Pacer pacer(execution);
  for (const Corners& t : triangles_) {
    pacer.step();
    area_ += length(cross(t[1] - t[0], t[2] - t[0])) / 2;
  }
  nodes_.reserve(triangles_.size() / 2 + 1);
  if (!triangles_.empty()) build(0, static_cast<std::uint32_t>(triangles_.size()), pacer);
}

void TriangleTree::build(std::uint32_t begin, std::uint32_t end, Pacer& pacer) {
  const std::size_t at = nodes_.size();
  nodes_.push_back({{}, begin, end, 0});
  Box middles;
  for (std::uint32_t t = begin; t < end; ++t) {
    pacer.step();
    for (const Vec3d& corner : triangles_[t]) nodes_[at].box.add(corner);
    middles.add(middle(triangles_[t]));
  }
  if (end - begin <= kLeaf) return;
  const Vec3d size = middles.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(triangles_.begin() + begin, triangles_.begin() + half, triangles_.begin() + end,
                   [&](const Corners& a, const Corners& b) {
                     pacer.step();
                     return middle(a)[axis] < middle(b)[axis];
                   });
  build(begin, half, pacer);
  nodes_[at].right = static_cast<std::uint32_t>(nodes_.size());
  build(half, end, pacer);
}

double TriangleTree::nearest(const Vec3d& point, double bound, bool any) const {
  if (nodes_.empty()) return bound;
  struct Waiting {
    std::uint32_t node;
    double squared;
  };
  Waiting stack[64];
  std::size_t size = 0;
  const auto push = [&](std::uint32_t node) {
    if (const double d = squared_distance(point, nodes_[node].box); d < bound) stack[size++] = {node, d};
  };
  push(0);
  while (size > 0) {
    const Waiting next = stack[--size];
    if (next.squared >= bound) continue;
    const Node& node = nodes_[next.node];
    if (node.right == 0) {
      for (std::uint32_t t = node.begin; t < node.end; ++t) {
        const double d = hollow_detail::squared_distance(point, triangles_[t]);
        if (d >= bound) continue;
        bound = d;
        if (any) return bound;
      }
      continue;
    }
    push(next.node + 1);
    push(node.right);
    if (size >= 2 && stack[size - 1].squared > stack[size - 2].squared)
      std::swap(stack[size - 1], stack[size - 2]);  // the nearer one first
  }
  return bound;
}

bool TriangleTree::within(const Vec3d& point, double distance) const {
  const double bound = distance * distance;
  return nearest(point, bound, /*any=*/true) < bound;
}

double TriangleTree::distance(const Vec3d& point) const {
  return std::sqrt(nearest(point, HUGE_VAL, /*any=*/false));
}

double TriangleTree::winding(const Vec3d& point, Pacer& pacer) const {
  double angle = 0;
  for (const Corners& t : triangles_) {
    pacer.step(4);
    const Vec3d a = t[0] - point, b = t[1] - point, c = t[2] - point;
    const double la = length(a), lb = length(b), lc = length(c);
    angle +=
        2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

}  // namespace fracture::hollow_detail
