#include "common/hollow/simplify.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>

#include "common/base/id.hpp"
#include "common/base/pacer.hpp"
#include "common/bvh/triangle_crossing.hpp"

namespace fracture::hollow_detail {
namespace {

/// Cosine of the maximum angle by which a triangle may turn.
constexpr double kMostTurn = 0.5;
/// Minimum of twice the area / square of the longest edge. Needles have less.
constexpr double kLeastHeight = 0.05;
/// Maximum number of triangles at one corner: those of both merged corners, minus the ones between them,
/// which both corners had.
constexpr std::size_t kMostAtACorner = 24, kBetween = 4;
/// Maximum number of times a triangle is halved to prove that it is deep.
constexpr int kMostHalvings = 12;
/// Exceeds the relative rounding error of a distance.
constexpr double kRounding = 1e-9;

using Corners = std::array<Vec3d, 3>;
using Triangle = std::array<std::uint32_t, 3>;

/// Sum of the squared distances to planes, weighted by area.
struct Quadric {
  std::array<double, 6> a{};  // xx xy xz yy yz zz
  Vec3d b;
  double c = 0, area = 0;

  void add(const Vec3d& normal, const Vec3d& on, double weight) {
    const double d = -dot(normal, on);
    a[0] += weight * normal.x * normal.x;
    a[1] += weight * normal.x * normal.y;
    a[2] += weight * normal.x * normal.z;
    a[3] += weight * normal.y * normal.y;
    a[4] += weight * normal.y * normal.z;
    a[5] += weight * normal.z * normal.z;
    b = b + (weight * d) * normal;
    c += weight * d * d;
    area += weight;
  }
  void add(const Quadric& q) {
    for (std::size_t k = 0; k < a.size(); ++k) a[k] += q.a[k];
    b = b + q.b;
    c += q.c;
    area += q.area;
  }
  double at(const Vec3d& p) const {
    return a[0] * p.x * p.x + a[3] * p.y * p.y + a[5] * p.z * p.z +
           2 * (a[1] * p.x * p.y + a[2] * p.x * p.z + a[4] * p.y * p.z + dot(b, p)) + c;
  }
};

Vec3d twice_area(const Corners& t) { return cross(t[1] - t[0], t[2] - t[0]); }

class Simplifier {
 public:
  Simplifier(const InnerSurface& surface, double tolerance, const SurfaceTree& outside, double depth,
             const Execution& execution)
      : surface_(surface),
        triangles_(surface.triangles),
        most_(tolerance * tolerance),
        outside_(outside),
        depth_(depth),
        pacer_(execution) {}

  InnerSurface run() {
    gather();
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      find_ways(v);
      offer_best(v);
    }
    while (!offers_.empty()) {
      const Offer best = offers_.top();
      offers_.pop();
      pacer_.step(4);
      if (best.to != best_[best.from].to || best.error != best_[best.from].error) continue;
      if (may_go(best.from, best.to)) {
        go(best.from, best.to);
      } else {
        refuse(best.from, best.to);
        offer_best(best.from);
      }
    }
    return left();
  }

 private:
  /// A possible merge of a corner into a neighbour, and its error.
  struct Way {
    double error;
    std::uint32_t to;
    bool refused;  ///< until something near the corner changes
  };
  /// The best merge of a corner. Entries in the queue are used only if they are still current. If the queue
  /// contained all merges of all corners, about forty would be added for each removed corner.
  struct Offer {
    double error;
    std::uint32_t from, to;
    bool operator<(const Offer& other) const {  // the queue puts its greatest element on top
      return std::tie(other.error, other.from, other.to) < std::tie(error, from, to);
    }
  };

  const Vec3d& point(std::uint32_t v) const { return points_[v]; }
  Corners corners(const Triangle& t) const { return {point(t[0]), point(t[1]), point(t[2])}; }

  /// Coordinates are relative to the middle of the surface, so that squares keep their precision.
  void gather() {
    Box box;
    for (const Vec3f& p : surface_.positions) box.add(to_double(p));
    middle_ = box.center();
    for (const Vec3f& p : surface_.positions) points_.push_back(to_double(p) - middle_);
    at_.resize(points_.size());
    ways_.resize(points_.size());
    quadric_.resize(points_.size());
    best_.assign(points_.size(), {0, kNoIndex, false});
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      pacer_.step(8);
      const Vec3d n = twice_area(corners(triangles_[t]));
      const double size = length(n);
      for (const std::uint32_t v : triangles_[t]) {
        at_[v].push_back(t);
        if (size > 0) quadric_[v].add((1 / size) * n, point(v), size);
      }
    }
  }

  /// Lists each neighbour once: an edge has two triangles, and it starts at v in only one of them.
  void list_neighbours(std::uint32_t v, std::vector<std::uint32_t>& out) const {
    out.clear();
    for (const std::uint32_t t : at_[v]) {
      const auto& [a, b, c] = triangles_[t];
      out.push_back(v == a ? b : v == b ? c : a);
    }
  }

  void find_ways(std::uint32_t v) {
    list_neighbours(v, neighbours_);
    pacer_.step(neighbours_.size());
    for (const std::uint32_t u : neighbours_) {
      Quadric both = quadric_[v];
      both.add(quadric_[u]);
      add_way(v, u, both);
    }
  }

  void add_way(std::uint32_t from, std::uint32_t to, const Quadric& both) {
    const double error = std::fmax(both.at(point(to)), 0) / both.area;
    if (error <= most_) ways_[from].push_back({error, to, false});
  }

  void refuse(std::uint32_t from, std::uint32_t to) {
    for (Way& way : ways_[from]) way.refused |= way.to == to;
  }

  void offer_best(std::uint32_t v) {
    const Way* best = nullptr;
    for (const Way& way : ways_[v])
      if (!way.refused && (!best || std::tie(way.error, way.to) < std::tie(best->error, best->to)))
        best = &way;
    Way& before = best_[v];
    if (!best)
      before.to = kNoIndex;
    else if (best->to != before.to || best->error != before.error)
      offers_.push({best->error, v, best->to});  // otherwise it is already in the queue
    if (best) before = *best;
  }

  bool may_go(std::uint32_t v, std::uint32_t u) {
    if (at_[v].size() + at_[u].size() > kMostAtACorner + kBetween) return false;
    list_neighbours(v, neighbours_);
    list_neighbours(u, others_);
    common_.clear();
    for (const std::uint32_t w : neighbours_)
      if (std::find(others_.begin(), others_.end(), w) != others_.end()) common_.push_back(w);
    if (common_.size() != 2 || at_[common_[0]].size() < 4 || at_[common_[1]].size() < 4) return false;
    pacer_.step(8 * at_[v].size());
    bool bulges = false;  // towards the outside; if not, the new surface is as deep as before
    for (const std::uint32_t t : at_[v]) {
      Triangle now = triangles_[t];
      if (std::find(now.begin(), now.end(), u) != now.end()) continue;
      const Vec3d before = twice_area(corners(now));
      bulges |= dot(before, point(u) - point(v)) < 0;
      std::replace(now.begin(), now.end(), v, u);
      if (!is_fair(corners(now), before)) return false;
    }
    return !bulges || is_deep_around(v, u);
  }

  bool is_fair(const Corners& t, const Vec3d& before) {
    const Vec3d now = twice_area(t);
    const double size = length(now);
    if (!(dot(now, before) > kMostTurn * size * length(before))) return false;
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3d edge = t[(k + 1) % 3] - t[k];
      longest = std::fmax(longest, dot(edge, edge));
    }
    return size > kLeastHeight * longest;
  }

  /// Tests the middles of u's new triangles and of their edges at u, each of which belongs to two triangles.
  bool is_deep_around(std::uint32_t v, std::uint32_t u) {
    for (const std::uint32_t t : at_[v]) {
      Triangle now = triangles_[t];
      if (std::find(now.begin(), now.end(), u) != now.end()) continue;
      const auto at = static_cast<std::size_t>(std::find(now.begin(), now.end(), v) - now.begin());
      const Vec3d &next = point(now[(at + 1) % 3]), &last = point(now[(at + 2) % 3]);
      for (const Vec3d& p : {(1.0 / 3) * (point(u) + next + last), 0.5 * (point(u) + next)})
        if (outside_.within(p + middle_, depth_, pacer_)) return false;
    }
    return true;
  }

  void go(std::uint32_t v, std::uint32_t u) {
    for (const std::uint32_t t : at_[v]) {
      Triangle& triangle = triangles_[t];
      const bool flat = std::find(triangle.begin(), triangle.end(), u) != triangle.end();
      if (flat) {
        for (const std::uint32_t w : triangle)
          if (w != v) std::erase(at_[w], t);
        triangle.fill(kNoIndex);
      } else {
        std::replace(triangle.begin(), triangle.end(), v, u);
        at_[u].push_back(t);
      }
    }
    at_[v].clear();
    ways_[v].clear();
    best_[v].to = kNoIndex;
    quadric_[u].add(quadric_[v]);
    list_neighbours(u, changed_);
    ways_[u].clear();
    pacer_.step(4 * changed_.size());
    for (const std::uint32_t w : changed_) {
      std::erase_if(ways_[w], [&](const Way& way) { return way.to == v || way.to == u; });
      for (Way& way : ways_[w]) way.refused = false;
      Quadric both = quadric_[w];
      both.add(quadric_[u]);
      add_way(w, u, both);
      add_way(u, w, both);
    }
    changed_.push_back(u);
    for (const std::uint32_t w : changed_) offer_best(w);
  }

  InnerSurface left() const {
    InnerSurface out;
    std::vector<std::uint32_t> number(points_.size(), kNoIndex);
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (at_[v].empty()) continue;
      number[v] = static_cast<std::uint32_t>(out.positions.size());
      out.positions.push_back(surface_.positions[v]);
    }
    for (const Triangle& t : triangles_)
      if (t[0] != kNoIndex) out.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    return out;
  }

  const InnerSurface& surface_;
  std::vector<Triangle> triangles_;
  const double most_;
  const SurfaceTree& outside_;
  const double depth_;
  Pacer pacer_;
  Vec3d middle_;
  std::vector<Vec3d> points_;
  std::vector<std::vector<std::uint32_t>> at_;  // triangles at each corner
  std::vector<std::vector<Way>> ways_;          // possible merges of each corner
  std::vector<Way> best_;                       // the best of these, in the queue; if none, to kNoIndex
  std::vector<Quadric> quadric_;
  std::priority_queue<Offer> offers_;
  std::vector<std::uint32_t> neighbours_, others_, common_, changed_;
};

Corners corners_at(const InnerSurface& surface, std::size_t t) {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = to_double(surface.positions[surface.triangles[t][k]]);
  return corners;
}

bool is_deep(const Corners& t, const SurfaceTree& outside, double depth, int halvings, Pacer& pacer) {
  const Vec3d middle = (1.0 / 3) * (t[0] + t[1] + t[2]);
  double radius = 0;
  std::size_t longest = 0;
  double square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    radius = std::fmax(radius, length(t[k] - middle));
    const Vec3d edge = t[(k + 1) % 3] - t[k];
    if (dot(edge, edge) > square) {
      square = dot(edge, edge);
      longest = k;
    }
  }
  const double distance = outside.distance(middle, depth + radius, pacer);
  if (distance >= depth + radius) return true;
  if (halvings == 0 || distance < (1 - kRounding) * depth) return false;
  // A triangle that is large compared with its extra depth would need thousands of middles.
  if (const std::optional<bool> near = outside.near_triangle(t, depth, pacer)) return !*near;
  const Vec3d &a = t[longest], &b = t[(longest + 1) % 3], &c = t[(longest + 2) % 3], half = 0.5 * (a + b);
  return is_deep({a, half, c}, outside, depth, halvings - 1, pacer) &&
         is_deep({half, b, c}, outside, depth, halvings - 1, pacer);
}

}  // namespace

InnerSurface simplified(const InnerSurface& surface, double tolerance, const SurfaceTree& outside,
                        double depth, const Execution& execution) {
  return Simplifier(surface, tolerance, outside, depth, execution).run();
}

bool is_deep(const InnerSurface& surface, const SurfaceTree& outside, double depth,
             const Execution& execution) {
  Pacer pacer(execution);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (!is_deep(corners_at(surface, t), outside, depth, kMostHalvings, pacer)) return false;
  return true;
}

bool crosses_itself(const InnerSurface& surface, const Execution& execution) {
  std::vector<PlaneTriangle> planes;
  std::vector<Box> boxes;
  Box all;
  Pacer pacer(execution);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    pacer.step();
    planes.emplace_back(corners_at(surface, t));
    boxes.push_back(box_of(planes.back().corners));
    all.add(boxes.back());
  }
  const double tolerance = 1e-9 * all.longest_side();  // the rounding errors of the planes are far smaller
  const BoxTree tree(boxes, execution);
  bool found = false;
  for (const BoxTree::Task& task : tree.pair_tasks(1))
    tree.each_pair(task, [&](std::uint32_t i, std::uint32_t j) {
      pacer.step();
      if (found) return;
      const Triangle &s = surface.triangles[i], &t = surface.triangles[j];
      const auto shared = std::count_if(
          s.begin(), s.end(), [&](std::uint32_t v) { return std::find(t.begin(), t.end(), v) != t.end(); });
      found = shared < 2 && cross_each_other(planes[i], planes[j], tolerance);
    });
  return found;
}

}  // namespace fracture::hollow_detail
