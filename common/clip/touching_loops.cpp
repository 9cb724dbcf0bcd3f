#include "common/clip/touching_loops.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "common/base/pacer.hpp"

namespace fracture {
namespace {

/// Number of parts of a lattice step.
constexpr std::int64_t kPartsOfStep = 16;
/// Parts by which each of its two edges moves a corner: half a step. This separates loops that touch, even if
/// rounding has moved a corner across an edge. Moving farther would close gaps of a few steps.
constexpr double kMoved = kPartsOfStep / 2.0;

/// An edge, seen from one of its ends.
struct Ray {
  LatticePoint to;  ///< its other end, relative to this one
  std::uint32_t corner;
  bool leaves;
  bool is_upper() const { return to.y > 0 || (to.y == 0 && to.x > 0); }
};

/// Compares angles, counter-clockwise from the x direction: negative, 0 or positive.
int compare(const Ray& a, const Ray& b) {
  if (a.is_upper() != b.is_upper()) return a.is_upper() ? -1 : 1;
  const std::int64_t turn = orient2d({0, 0}, a.to, b.to);
  return turn > 0 ? -1 : turn < 0 ? 1 : 0;
}

class Linker {
 public:
  Linker(std::span<const LatticePoint> points, const std::vector<std::uint32_t>& corners,
         const std::vector<std::uint32_t>& begin)
      : points_(points), corners_(corners) {
    const std::size_t n = corners.size();
    next_.resize(n);
    prev_.resize(n);
    for (std::size_t l = 0; l + 1 < begin.size(); ++l)
      for (std::uint32_t k = begin[l]; k < begin[l + 1]; ++k) {
        next_[k] = k + 1 < begin[l + 1] ? k + 1 : begin[l];
        prev_[next_[k]] = k;
      }
    leave_.resize(n);
    std::iota(leave_.begin(), leave_.end(), 0u);
  }

  void link(const Execution& execution) {
    std::vector<std::uint32_t> order = leave_;
    sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::tie(at(a).x, at(a).y, a) < std::tie(at(b).x, at(b).y, b);
    });
    Pacer pacer(execution);
    for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
      while (end < order.size() && at(order[end]) == at(order[first])) ++end;
      pacer.step(4 * (end - first));
      if (end - first > 1) link_place({order.data() + first, end - first});
    }
  }

  // The edge that arrives at corner a continues with the edge from another corner l at the same position to
  // b. In the new ring, b follows a, so the triangle (a, l, b) connects that edge to its ring. Corners a, l =
  // leave_[a], leave_[l], ... form a cycle. The region that they enclose at their position is filled from the
  // first of them.
  void add_flat(std::vector<std::array<std::uint32_t, 3>>& triangles) const {
    std::vector<bool> done(leave_.size(), false);
    for (std::uint32_t first = 0; first < leave_.size(); ++first) {
      if (done[first] || leave_[first] == first) continue;
      for (std::uint32_t a = first; !done[a]; a = leave_[a]) {
        done[a] = true;
        const std::uint32_t l = leave_[a];
        triangles.push_back({corners_[a], corners_[l], corners_[next_[l]]});
        if (a != first && l != first) triangles.push_back({corners_[first], corners_[l], corners_[a]});
      }
    }
  }

  void collect(std::vector<std::uint32_t>& corners, std::vector<std::uint32_t>& begin) const {
    std::vector<std::uint32_t> rings;
    rings.reserve(leave_.size());
    begin.assign(1, 0);
    std::vector<bool> done(leave_.size(), false);
    for (std::uint32_t start = 0; start < leave_.size(); ++start) {
      if (done[start]) continue;
      for (std::uint32_t k = start; !done[k]; k = next_[leave_[k]]) {
        done[k] = true;
        rings.push_back(corners_[k]);
      }
      begin.push_back(static_cast<std::uint32_t>(rings.size()));
    }
    corners = std::move(rings);
  }

 private:
  const LatticePoint& at(std::uint32_t k) const { return points_[corners_[k]]; }

  void link_place(std::span<const std::uint32_t> here) {
    rays_.clear();
    for (const std::uint32_t k : here) {
      const LatticePoint &p = at(k), &before = at(prev_[k]), &after = at(next_[k]);
      if (prev_[k] == k) continue;  // a loop of one corner has no edges
      rays_.push_back({{before.x - p.x, before.y - p.y}, k, false});
      rays_.push_back({{after.x - p.x, after.y - p.y}, k, true});
    }
    std::sort(rays_.begin(), rays_.end(), [](const Ray& a, const Ray& b) {
      const int order = compare(a, b);
      return order != 0 ? order < 0 : std::tie(a.leaves, a.corner) < std::tie(b.leaves, b.corner);
    });
    if (!alternate()) return;
    for (std::size_t k = 0; k < around_.size(); ++k)
      if (around_[k].leaves) leave_[around_[(k + 1) % around_.size()].corner] = around_[k].corner;
  }

  /// Fills around_ with the rays, counter-clockwise, so that each leaving ray is followed by an arriving one,
  /// with the inside between them. Rays with the same direction may be in any order. Returns false if no such
  /// order exists.
  bool alternate() {
    const std::size_t n = rays_.size();
    const auto end_of = [&](std::size_t first) {
      std::size_t end = first + 1;
      while (end < n && compare(rays_[first], rays_[end]) == 0) ++end;
      return end;
    };
    // Begin with a direction in which all rays are of one kind. If there is none, each direction is the end
    // of a spike.
    std::size_t start = 0;
    while (start < n && rays_[start].leaves != rays_[end_of(start) - 1].leaves) start = end_of(start);
    bool leaves = start == n || rays_[start].leaves;
    if (start == n) start = 0;
    around_.clear();
    for (std::size_t first = start; around_.size() < n;) {
      const std::size_t end = end_of(first);
      std::size_t arriving = first, leaving = first;
      while (leaving < end && !rays_[leaving].leaves) ++leaving;  // arriving rays come first
      for (const std::size_t middle = leaving; arriving < middle || leaving < end; leaves = !leaves) {
        if (leaves ? leaving == end : arriving == middle) return false;
        around_.push_back(rays_[leaves ? leaving++ : arriving++]);
      }
      first = end == n ? 0 : end;
    }
    return true;
  }

  std::span<const LatticePoint> points_;
  const std::vector<std::uint32_t>& corners_;
  // Indices into corners_:
  std::vector<std::uint32_t> next_, prev_;
  // The edge that arrives here continues with the one that leaves from there
  std::vector<std::uint32_t> leave_;
  std::vector<Ray> rays_, around_;
};

}  // namespace

void link_touching_loops(std::span<const LatticePoint> points, std::vector<std::uint32_t>& corners,
                         std::vector<std::uint32_t>& begin,
                         std::vector<std::array<std::uint32_t, 3>>& triangles, const Execution& execution) {
  Linker linker(points, corners, begin);
  linker.link(execution);
  linker.add_flat(triangles);
  linker.collect(corners, begin);
}

std::vector<LatticePoint> moved_inwards(std::span<const LatticePoint> points,
                                        std::span<const std::uint32_t> corners,
                                        std::span<const std::uint32_t> begin, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<LatticePoint> moved;
  moved.reserve(corners.size());
  for (std::size_t l = 0; l + 1 < begin.size(); ++l)
    for (std::uint32_t k = begin[l]; k < begin[l + 1]; ++k) {
      pacer.step();
      const LatticePoint& at = points[corners[k]];
      double x = 0, y = 0;  // the sum of the normals of both edges
      const auto add_normal = [&](const LatticePoint& from, const LatticePoint& to) {
        const auto dx = static_cast<double>(to.x - from.x), dy = static_cast<double>(to.y - from.y);
        const double length = std::sqrt(dx * dx + dy * dy);
        if (!(length > 0)) return;  // a loop of one corner
        x -= dy / length;
        y += dx / length;
      };
      add_normal(points[corners[k > begin[l] ? k - 1 : begin[l + 1] - 1]], at);
      add_normal(at, points[corners[k + 1 < begin[l + 1] ? k + 1 : begin[l]]]);
      moved.push_back({kPartsOfStep * at.x + static_cast<std::int64_t>(std::nearbyint(kMoved * x)),
                       kPartsOfStep * at.y + static_cast<std::int64_t>(std::nearbyint(kMoved * y))});
    }
  return moved;
}

}  // namespace fracture
