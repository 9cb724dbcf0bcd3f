#include "common/rough/crossings.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

namespace fracture {
namespace {

using Corners = std::array<Vec3d, 3>;

double height(const PlaneTriangle& t, const Vec3d& p) { return dot(t.normal, p - t.corners[0]); }

/// Are there points of s on both sides of the plane of t?
bool parts(const PlaneTriangle& t, const PlaneTriangle& s, double tolerance) {
  const double a = height(t, s.corners[0]), b = height(t, s.corners[1]), c = height(t, s.corners[2]);
  return (a > tolerance || b > tolerance || c > tolerance) &&
         (a < -tolerance || b < -tolerance || c < -tolerance);
}

/// x in the plane: farther than the tolerance inside all sides?
bool contains(const PlaneTriangle& t, const Vec3d& x, double tolerance) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d side = t.corners[(k + 1) % 3] - t.corners[k];
    if (!(dot(t.normal, cross(side, x - t.corners[k])) > tolerance * length(side))) return false;
  }
  return true;
}

bool edges_pierce(const PlaneTriangle& s, const PlaneTriangle& t, double tolerance) {
  std::array<double, 3> h{};
  for (std::size_t k = 0; k < 3; ++k) h[k] = height(t, s.corners[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    const double p = h[k], q = h[(k + 1) % 3];
    if (!((p > tolerance && q < -tolerance) || (p < -tolerance && q > tolerance))) continue;
    const Vec3d& from = s.corners[k];
    if (contains(t, from + (p / (p - q)) * (s.corners[(k + 1) % 3] - from), tolerance)) return true;
  }
  return false;
}

std::vector<Box> reachable_boxes(const CapSurface& caps) {
  std::vector<Box> boxes(caps.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (const VertexId v : caps.triangles[t]) {
      boxes[t].add(caps.flat[v - caps.first]);
      boxes[t].add(caps.points[v - caps.first]);
    }
  return boxes;
}

}  // namespace

PlaneTriangle::PlaneTriangle(const Corners& t) : corners(t), normal(cross(t[1] - t[0], t[2] - t[0])) {
  const double l = length(normal);
  normal = l > 0 ? (1 / l) * normal : Vec3d{};
}

bool cross_each_other(const PlaneTriangle& s, const PlaneTriangle& t, double tolerance) {
  // Where one lies on one side of the other's plane, nothing is pierced.
  if (!parts(t, s, tolerance) || !parts(s, t, tolerance)) return false;
  return edges_pierce(s, t, tolerance) || edges_pierce(t, s, tolerance);
}

Crossings::Crossings(const CapSurface& caps, const SurfaceTree& outside, double tolerance)
    : caps_(caps), outside_(outside), tolerance_(tolerance), tree_(reachable_boxes(caps)) {}

Corners Crossings::corners(std::size_t t) const {
  const auto& v = caps_.triangles[t];
  return {caps_.points[v[0] - caps_.first], caps_.points[v[1] - caps_.first],
          caps_.points[v[2] - caps_.first]};
}

bool Crossings::is_moved(std::size_t t) const {
  const auto& v = caps_.triangles[t];
  return caps_.moved[v[0] - caps_.first] || caps_.moved[v[1] - caps_.first] ||
         caps_.moved[v[2] - caps_.first];
}

bool Crossings::pair_crosses(std::uint32_t s, std::uint32_t t) const {
  int shared = 0;
  for (const VertexId v : caps_.triangles[s])
    for (const VertexId w : caps_.triangles[t]) shared += v == w;
  return shared < 2 && cross_each_other(now_[s], now_[t], tolerance_) && (is_moved(s) || is_moved(t));
}

bool Crossings::leaves_surface(std::uint32_t t) const {
  if (!is_moved(t)) return false;
  // Can it have reached the outer surface? Its flat points are within 0.58 of its longest edge of a corner.
  const Corners& c = now_[t].corners;
  double longest = 0, move = 0, surface = HUGE_VAL;
  for (std::size_t k = 0; k < 3; ++k) {
    longest = std::fmax(longest, length(c[(k + 1) % 3] - c[k]));
    const double distance = caps_.surface[caps_.triangles[t][k] - caps_.first];
    move = std::fmax(move, distance);
    surface = std::fmin(surface, distance);
  }
  if (!(surface < 0.58 * longest + move)) return false;
  bool leaves = false;
  outside_.each_near(box_of(c), [&](std::uint32_t other) {
    leaves = leaves || cross_each_other(now_[t], PlaneTriangle(outside_.corners(other)), tolerance_);
  });
  return leaves;
}

std::uint64_t Crossings::find(const std::vector<char>& suspects, std::vector<char>& crossing,
                              const Execution& execution) {
  const auto n = static_cast<std::uint32_t>(caps_.triangles.size());
  const bool first_look = now_.empty();
  std::vector<std::uint32_t> changed;
  if (first_look) {
    now_.reserve(n);
    for (std::uint32_t t = 0; t < n; ++t) now_.emplace_back(corners(t));
    changed.resize(n);
    std::iota(changed.begin(), changed.end(), 0u);
  } else {
    for (std::uint32_t t = 0; t < n; ++t)
      if (suspects[t]) {
        now_[t] = PlaneTriangle(corners(t));
        changed.push_back(t);
      }
  }

  std::atomic<std::uint64_t> count{0};
  crossing.assign(n, 0);
  const auto mark = [&](std::uint32_t t) {
    std::atomic_ref(crossing[t]).store(1, std::memory_order_relaxed);
  };
  const auto look = [&](std::uint32_t s, std::uint32_t t) {
    if (!pair_crosses(s, t)) return;
    mark(s);
    mark(t);
    count.fetch_add(1, std::memory_order_relaxed);
  };
  if (first_look) {
    const std::vector<BoxTree::Task> tasks = tree_.pair_tasks(execution.threads > 1 ? 64 : 1);
    parallel_for(execution, tasks.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) tree_.each_pair(tasks[k], look);
    });
  }
  parallel_for(execution, changed.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t s = changed[k];
      if (!first_look)
        tree_.each_overlapping(box_of(now_[s].corners), [&](std::uint32_t t) {
          if (t != s && (!suspects[t] || s < t)) look(s, t);
        });
      if (!leaves_surface(s)) continue;
      mark(s);
      count.fetch_add(1, std::memory_order_relaxed);
    }
  });
  return count;
}

}  // namespace fracture
