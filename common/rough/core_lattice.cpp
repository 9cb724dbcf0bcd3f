#include "common/rough/core_lattice.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/id.hpp"

namespace fracture {
namespace {

/// Distance between the core and the loops, in lengths. More than 1/sqrt(3), the radius of a triangle's
/// circumcircle; so an edge that passes through a triangle is too near to one of its corners.
constexpr double kMargin = 0.6;
/// Maximum number of lattice points in the box of the loops, per lattice point that fits into their area.
constexpr double kMostEmpty = 64;
/// Maximum number of passes that remove pinches. One is enough for nearly all regions.
constexpr int kMostPasses = 16;
constexpr double kHalfRoot3 = 0.8660254037844386;

}  // namespace

void CoreLattice::build(std::span<const Vec2d> plane, std::span<const std::uint32_t> loop_begin,
                        double length, double area, const Execution& execution) {
  Pacer pacer(execution);
  points_.clear();
  triangles_.clear();
  rim_.clear();
  rim_begin_.assign(1, 0);
  if (!lay_out(plane, length, area)) return;
  mark_inside(plane, loop_begin, pacer);
  for (std::size_t l = 0; l + 1 < loop_begin.size(); ++l)
    for (std::uint32_t k = loop_begin[l]; k < loop_begin[l + 1]; ++k)
      clear_near(plane[k], plane[k + 1 < loop_begin[l + 1] ? k + 1 : loop_begin[l]], pacer);
  // Each pass scans the whole core. A core that still has pinches after kMostPasses passes is not worth having.
  int passes = 0;
  while (remove_pinches(execution))
    if (++passes == kMostPasses) return;
  collect(pacer);
}

bool CoreLattice::lay_out(std::span<const Vec2d> plane, double length, double area) {
  Vec2d high = plane[0];
  low_ = plane[0];
  for (const Vec2d& p : plane) {
    low_ = {std::fmin(low_.x, p.x), std::fmin(low_.y, p.y)};
    high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y)};
  }
  length_ = length;
  height_ = kHalfRoot3 * length;
  const double columns = std::floor((high.x - low_.x) / length_) + 1,
               rows = std::floor((high.y - low_.y) / height_) + 1;
  if (rows < 3 || columns < 3 || rows * columns > kMostEmpty * (area / (length_ * height_) + 64))
    return false;
  rows_ = static_cast<std::int64_t>(rows);
  columns_ = static_cast<std::int64_t>(columns);
  usable_.assign(static_cast<std::size_t>(rows_ * columns_), 0);
  return true;
}

// Computes the winding number along each row. It increases where a loop crosses the row downwards, seen from
// the left.
void CoreLattice::mark_inside(std::span<const Vec2d> plane, std::span<const std::uint32_t> loop_begin,
                              Pacer& pacer) {
  std::vector<std::vector<std::pair<double, int>>> rows(static_cast<std::size_t>(rows_));
  for (std::size_t l = 0; l + 1 < loop_begin.size(); ++l)
    for (std::uint32_t k = loop_begin[l]; k < loop_begin[l + 1]; ++k) {
      const Vec2d &a = plane[k], &b = plane[k + 1 < loop_begin[l + 1] ? k + 1 : loop_begin[l]];
      if (a.y == b.y) continue;
      const Vec2d &under = a.y < b.y ? a : b, &over = a.y < b.y ? b : a;
      auto row = static_cast<std::int64_t>(std::floor((under.y - low_.y) / height_)) - 1;
      for (row = std::max<std::int64_t>(row, 0); row < rows_ && y_of(row) <= over.y; ++row) {
        pacer.step();
        if (y_of(row) <= under.y) continue;
        const double t = (y_of(row) - under.y) / (over.y - under.y);
        rows[static_cast<std::size_t>(row)].emplace_back(under.x + t * (over.x - under.x),
                                                         a.y > b.y ? 1 : -1);
      }
    }
  for (std::int64_t row = 0; row < rows_; ++row) {
    auto& crossings = rows[static_cast<std::size_t>(row)];
    pacer.step(static_cast<std::uint64_t>(columns_) + 8 * crossings.size());
    std::sort(crossings.begin(), crossings.end());
    int winding = 0;
    std::size_t next = 0;
    for (std::int64_t column = 0; column < columns_; ++column) {
      for (; next < crossings.size() && crossings[next].first <= x_of(row, column); ++next)
        winding += crossings[next].second;
      usable_[index({row, column})] = winding == 1;
    }
  }
}

void CoreLattice::clear_near(const Vec2d& a, const Vec2d& b, Pacer& pacer) {
  const double margin = kMargin * length_;
  const Vec2d e{b.x - a.x, b.y - a.y};
  const double square = e.x * e.x + e.y * e.y;
  const double bottom = std::fmin(a.y, b.y) - margin, top = std::fmax(a.y, b.y) + margin;
  const auto first =
      std::max<std::int64_t>(static_cast<std::int64_t>(std::floor((bottom - low_.y) / height_)), 0);
  for (std::int64_t row = first; row < rows_ && y_of(row) <= top; ++row) {
    // The part of the edge within the margin of the row.
    double from = 0, to = 1;
    if (e.y != 0) {
      const double s = (y_of(row) - margin - a.y) / e.y, t = (y_of(row) + margin - a.y) / e.y;
      from = std::fmax(0, std::fmin(s, t));
      to = std::fmin(1, std::fmax(s, t));
    }
    const double x0 = a.x + from * e.x, x1 = a.x + to * e.x;
    const double left = std::fmin(x0, x1) - margin, right = std::fmax(x0, x1) + margin;
    auto column = static_cast<std::int64_t>(std::floor((left - low_.x) / length_)) - 1;
    for (column = std::max<std::int64_t>(column, 0); column < columns_ && x_of(row, column) <= right;
         ++column) {
      pacer.step();
      const Vec2d d{x_of(row, column) - a.x, y_of(row) - a.y};
      const double t = square > 0 ? std::fmin(std::fmax((d.x * e.x + d.y * e.y) / square, 0), 1) : 0;
      const double x = d.x - t * e.x, y = d.y - t * e.y;
      if (x * x + y * y < margin * margin) usable_[index({row, column})] = 0;
    }
  }
}

template <class Visit>
void CoreLattice::each_triangle(Pacer& pacer, const Visit& visit) const {
  // In even rows, (r, c) is below and between (r+1, c-1) and (r+1, c); in odd rows, (r+1, c) and (r+1, c+1).
  for (std::int64_t r = 0; r + 1 < rows_; ++r)
    pacer.each(0, static_cast<std::size_t>(columns_), [&](std::size_t column) {
      const auto c = static_cast<std::int64_t>(column), left = (r & 1) ? c : c - 1;
      const Point bottom{r, c}, top_left{r + 1, left}, top_right{r + 1, left + 1}, next{r, c + 1};
      if (!usable(bottom) || !usable(top_right)) return;
      if (usable(top_left)) visit(bottom, top_right, top_left);
      if (usable(next)) visit(bottom, next, top_right);
    });
}

/// The third corner of the triangle across the edge a-b from c. In the lattice's own oblique coordinates,
/// where x = column' + row / 2, it is a + b - c.
CoreLattice::Point CoreLattice::opposite(const Point& a, const Point& b, const Point& c) {
  const auto shift = [](std::int64_t row) { return row >> 1; };
  const std::int64_t row = a.row + b.row - c.row;
  const std::int64_t oblique = a.column - shift(a.row) + b.column - shift(b.row) - (c.column - shift(c.row));
  return {row, oblique + shift(row)};
}

/// Finds the edges of the rim, and removes points that several of these edges leave. Once there are none, the
/// loops of the rim are simple.
bool CoreLattice::remove_pinches(const Execution& execution) {
  Pacer pacer(execution);
  rim_edges_.clear();
  each_triangle(pacer, [&](const Point& a, const Point& b, const Point& c) {
    if (!usable(opposite(a, b, c))) rim_edges_.push_back({index(a), index(b)});
    if (!usable(opposite(b, c, a))) rim_edges_.push_back({index(b), index(c)});
    if (!usable(opposite(c, a, b))) rim_edges_.push_back({index(c), index(a)});
  });
  sort_with_polls(execution, rim_edges_.begin(), rim_edges_.end());
  bool removed = false;
  for (std::size_t k = 1; k < rim_edges_.size(); ++k)
    if (rim_edges_[k][0] == rim_edges_[k - 1][0]) {
      usable_[rim_edges_[k][0]] = 0;
      removed = true;
    }
  return removed;
}

void CoreLattice::collect(Pacer& pacer) {
  number_.assign(usable_.size(), kNoIndex);
  const auto number_of = [&](const Point& point) {
    std::uint32_t& n = number_[index(point)];
    if (n == kNoIndex) {
      n = static_cast<std::uint32_t>(points_.size());
      points_.push_back({x_of(point.row, point.column), y_of(point.row)});
    }
    return n;
  };
  each_triangle(pacer, [&](const Point& a, const Point& b, const Point& c) {
    const std::uint32_t i = number_of(a), j = number_of(b), k = number_of(c);
    triangles_.push_back({i, j, k});
  });
  // One edge of the rim leaves each of its points. Follow them backwards, so that the core is on the right.
  std::vector<std::uint32_t> before(points_.size(), kNoIndex);
  for (const auto& e : rim_edges_) before[number_[e[1]]] = number_[e[0]];
  for (const auto& e : rim_edges_) {
    pacer.step();
    std::uint32_t at = number_[e[0]];
    if (before[at] == kNoIndex) continue;
    while (before[at] != kNoIndex) {
      rim_.push_back(at);
      const std::uint32_t next = before[at];
      before[at] = kNoIndex;
      at = next;
    }
    rim_begin_.push_back(static_cast<std::uint32_t>(rim_.size()));
  }
}

}  // namespace fracture
