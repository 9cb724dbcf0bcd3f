#include "common/voronoi/site_tree.hpp"

#include <algorithm>

namespace fracture {

SiteTree::SiteTree(std::span<const Vec3d> points) {
  points_.reserve(points.size());
  for (std::uint32_t k = 0; k < points.size(); ++k) points_.push_back({points[k], k});
  if (!points_.empty()) build(0, 0, static_cast<std::uint32_t>(points_.size()));
}

void SiteTree::build(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
  Box box;
  for (std::uint32_t k = begin; k < end; ++k) box.add(points_[k].at);
  if (nodes_.size() <= node) nodes_.resize(node + 1);
  nodes_[node] = box;
  if (end - begin <= kLeaf) return;
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (box.max[a] - box.min[a] > box.max[axis] - box.min[axis]) axis = a;
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::uint32_t k) { return points_.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(at(begin), at(middle), at(end), [axis](const Point& p, const Point& q) {
    return p.at[axis] != q.at[axis] ? p.at[axis] < q.at[axis] : p.number < q.number;
  });
  build(2 * node + 1, begin, middle);
  build(2 * node + 2, middle, end);
}

}  // namespace fracture
