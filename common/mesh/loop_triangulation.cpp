#include "common/mesh/loop_triangulation.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

#include "common/base/error.hpp"
#include "common/base/pacer.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::solid_detail {
namespace {

/// Twice the vector area of the loop (Newell).
Vec3d vector_area(const std::vector<Vec3f>& corners, Pacer& pacer) {
  const Vec3d origin = to_double(corners[0]);
  Vec3d sum;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    pacer.step();
    sum = sum + cross(to_double(corners[i]) - origin, to_double(corners[i + 1]) - origin);
  }
  return sum;
}

std::vector<LoopTriangle> least_area(const std::vector<Vec3f>& corners) {
  const std::size_t n = corners.size();
  std::vector<double> cost(n * n, 0);
  std::vector<std::uint32_t> choice(n * n, 0);
  const auto point = [&](std::size_t i) { return to_double(corners[i]); };
  // The area decides. A small share of the squared edge lengths prevents slivers if areas are equal (planar
  // loops).
  const auto weight = [&](std::size_t i, std::size_t j, std::size_t k) {
    const Vec3d u = point(j) - point(i), v = point(k) - point(i), w = point(k) - point(j);
    return length(cross(u, v)) + 1e-5 * (dot(u, u) + dot(v, v) + dot(w, w));
  };
  for (std::size_t span = 2; span < n; ++span)
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t k = i + span;
      double best = HUGE_VAL;
      for (std::size_t j = i + 1; j < k; ++j) {
        const double c = cost[i * n + j] + cost[j * n + k] + weight(i, j, k);
        if (c < best) {
          best = c;
          choice[i * n + k] = static_cast<std::uint32_t>(j);
        }
      }
      cost[i * n + k] = best;
    }
  std::vector<LoopTriangle> triangles;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> todo{{0, static_cast<std::uint32_t>(n - 1)}};
  while (!todo.empty()) {
    const auto [i, k] = todo.back();
    todo.pop_back();
    if (k - i < 2) continue;
    const std::uint32_t j = choice[i * n + k];
    triangles.push_back({i, j, k});
    todo.emplace_back(j, k);
    todo.emplace_back(i, j);
  }
  return triangles;
}

/// Triangulates a projected loop by cutting ears.
class EarCutter {
 public:
  EarCutter(const std::vector<Vec3f>& corners, const Execution& execution)
      : pacer_(execution), count_(static_cast<std::uint32_t>(corners.size())) {
    const Vec3d normal = vector_area(corners, pacer_);
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (std::fabs(normal[a]) > std::fabs(normal[axis])) axis = a;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const bool mirrored = normal[axis] < 0;
    points_.reserve(count_);
    space_.reserve(count_);
    for (const Vec3f& corner : corners) {
      pacer_.step();
      const Vec3d p = to_double(corner);
      space_.push_back(p);
      points_.push_back(mirrored ? Vec2d{p[v], p[u]} : Vec2d{p[u], p[v]});
    }
    next_.resize(count_);
    previous_.resize(count_);
    version_.assign(count_, 0);
    waiting_first_.assign(count_, kNoIndex);
    reflex_.resize(count_);
    for (std::uint32_t i = 0; i < count_; ++i) {
      pacer_.step();
      next_[i] = i + 1 == count_ ? 0 : i + 1;
      previous_[i] = i == 0 ? count_ - 1 : i - 1;
      reflex_[i] = turn(i) <= 0;
    }
    build_grid();
    looks_left_ = kLooksPerCorner * count_;
  }

  std::vector<LoopTriangle> run() {
    std::vector<LoopTriangle> triangles;
    triangles.reserve(count_ - 2);
    for (std::uint32_t i = 0; i < count_; ++i) {
      pacer_.step(4);
      push(i);
    }
    std::uint32_t left = count_;
    while (left > 3) {
      std::uint32_t ear = kNoIndex;
      while (ear == kNoIndex && !queue_.empty()) {
        pacer_.step(8);  // each level of the queue counts as a step
        const Candidate candidate = queue_.top();
        queue_.pop();
        if (candidate.version != version_[candidate.corner]) continue;
        const std::uint32_t blocker = forced_ ? kNoIndex : blocking(candidate.corner);
        if (looks_left_ < 0 && !forced_) break;
        if (blocker == kNoIndex) {
          ear = candidate.corner;
        } else {  // tested again when the blocker is cut or becomes convex
          waiting_.push_back({candidate.corner, candidate.version, waiting_first_[blocker]});
          waiting_first_[blocker] = static_cast<std::uint32_t>(waiting_.size() - 1);
        }
      }
      if (ear == kNoIndex) {  // no proper ear is left, or searching for one costs too much
        force();
        continue;
      }
      triangles.push_back({previous_[ear], ear, next_[ear]});
      cut(ear);
      --left;
    }
    std::uint32_t last = 0;
    while (version_[last] == kCut) ++last;
    triangles.push_back({previous_[last], last, next_[last]});
    return triangles;
  }

 private:
  static constexpr std::uint32_t kCut = 0xffffffffu;
  /// Limits the work on loops whose projection is tangled. Outlines of real holes need a few dozen looks per
  /// corner.
  static constexpr std::int64_t kLooksPerCorner = 500;
  struct Candidate {
    bool poor;  // only when forced: the corner is not convex
    double diagonal;
    std::uint32_t corner, version;
    bool operator<(const Candidate& o) const {  // std::priority_queue puts the largest on top
      if (poor != o.poor) return poor;
      if (diagonal != o.diagonal) return diagonal > o.diagonal;
      return corner > o.corner;
    }
  };

  static double cross2(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  }
  double turn(std::uint32_t i) const { return cross2(points_[previous_[i]], points_[i], points_[next_[i]]); }

  void push(std::uint32_t i) {
    if (reflex_[i] && !forced_) return;
    const Vec3d d = space_[next_[i]] - space_[previous_[i]];
    queue_.push({reflex_[i] != 0, dot(d, d), i, version_[i]});
  }

  /// Makes every corner a candidate from now on, convex ones first.
  void force() {
    if (forced_) throw InternalError("ear cutting: no candidate left");
    forced_ = true;
    for (std::uint32_t i = 0; i < count_; ++i) {
      pacer_.step(4);
      if (version_[i] != kCut) push(i);
    }
  }

  void release(std::uint32_t blocker) {
    std::uint32_t i = waiting_first_[blocker];
    waiting_first_[blocker] = kNoIndex;
    for (; i != kNoIndex; i = waiting_[i].next) {
      pacer_.step();
      if (waiting_[i].version == version_[waiting_[i].corner]) push(waiting_[i].corner);
    }
  }

  void cut(std::uint32_t ear) {
    const std::uint32_t p = previous_[ear], n = next_[ear];
    version_[ear] = kCut;
    next_[p] = n;
    previous_[n] = p;
    release(ear);
    for (const std::uint32_t i : {p, n}) {
      ++version_[i];
      const bool was_reflex = reflex_[i];
      reflex_[i] = turn(i) <= 0;
      push(i);
      if (was_reflex && !reflex_[i]) release(i);
    }
  }

  /// Returns a reflex corner inside or on the triangle at this corner, or kNoIndex. Corners at the same
  /// position as one of its corners do not block, because loops may touch themselves.
  std::uint32_t blocking(std::uint32_t ear) {
    looks_left_ -= 16;  // cost of a search that finds nothing; also bounds the memory of waiting_
    const std::uint32_t ip = previous_[ear], in = next_[ear];
    const Vec2d a = points_[ip], b = points_[ear], c = points_[in];
    const auto [x0, y0] = cell(std::fmin(a.x, std::fmin(b.x, c.x)), std::fmin(a.y, std::fmin(b.y, c.y)));
    const auto [x1, y1] = cell(std::fmax(a.x, std::fmax(b.x, c.x)), std::fmax(a.y, std::fmax(b.y, c.y)));
    for (std::uint32_t y = y0; y <= y1 && looks_left_ >= 0; ++y)
      for (std::uint32_t x = x0; x <= x1; ++x, --looks_left_) {
        pacer_.step();
        for (std::uint32_t k = cell_start_[y * side_ + x]; k < cell_start_[y * side_ + x + 1]; ++k) {
          const std::uint32_t i = cell_items_[k];
          --looks_left_;
          pacer_.step();
          if (version_[i] == kCut || !reflex_[i] || i == ip || i == ear || i == in) continue;
          const Vec2d& p = points_[i];
          if (p == a || p == b || p == c) continue;
          if (cross2(a, b, p) >= 0 && cross2(b, c, p) >= 0 && cross2(c, a, p) >= 0) return i;
        }
      }
    return kNoIndex;
  }

  std::pair<std::uint32_t, std::uint32_t> cell(double x, double y) const {
    const auto clamp = [this](double t) {
      return static_cast<std::uint32_t>(std::fmin(std::fmax(t, 0.0), static_cast<double>(side_ - 1)));
    };
    return {clamp((x - low_.x) * scale_.x), clamp((y - low_.y) * scale_.y)};
  }
  void build_grid() {
    Vec2d high{-HUGE_VAL, -HUGE_VAL};
    low_ = {HUGE_VAL, HUGE_VAL};
    std::size_t items = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      pacer_.step();
      low_ = {std::fmin(low_.x, points_[i].x), std::fmin(low_.y, points_[i].y)};
      high = {std::fmax(high.x, points_[i].x), std::fmax(high.y, points_[i].y)};
      items += reflex_[i];
    }
    side_ = 1 + static_cast<std::uint32_t>(std::sqrt(static_cast<double>(items)));
    scale_ = {high.x > low_.x ? side_ / (high.x - low_.x) : 0,
              high.y > low_.y ? side_ / (high.y - low_.y) : 0};
    cell_start_.assign(static_cast<std::size_t>(side_) * side_ + 2, 0);
    cell_items_.resize(items);
    const auto index = [this](std::uint32_t i) {
      const auto [x, y] = cell(points_[i].x, points_[i].y);
      return y * side_ + x;
    };
    for (std::uint32_t i = 0; i < count_; ++i) {
      pacer_.step();
      if (reflex_[i]) ++cell_start_[index(i) + 2];
    }
    for (std::size_t k = 2; k < cell_start_.size(); ++k) cell_start_[k] += cell_start_[k - 1];
    for (std::uint32_t i = 0; i < count_; ++i) {
      pacer_.step();
      if (reflex_[i]) cell_items_[cell_start_[index(i) + 1]++] = i;
    }
  }

  Pacer pacer_;
  std::uint32_t count_;
  std::vector<Vec3d> space_;
  std::vector<Vec2d> points_;
  std::vector<std::uint32_t> next_, previous_, version_, waiting_first_;
  struct Waiting {
    std::uint32_t corner, version, next;
  };
  std::vector<Waiting> waiting_;
  std::int64_t looks_left_ = 0;  ///< number of cells and corners that blocking() may still test
  std::vector<std::uint8_t> reflex_;
  std::priority_queue<Candidate> queue_;
  bool forced_ = false;
  std::uint32_t side_ = 1;
  Vec2d low_, scale_;
  std::vector<std::uint32_t> cell_start_, cell_items_;
};

}  // namespace

std::vector<LoopTriangle> triangulate_loop(const std::vector<Vec3f>& corners, const Execution& execution) {
  if (corners.size() <= kSmallLoop) return least_area(corners);
  return EarCutter(corners, execution).run();
}

}  // namespace fracture::solid_detail
