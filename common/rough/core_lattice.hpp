// The triangles of an equilateral lattice that are well inside a set of loops in the plane.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// A lattice with rows of points `length` apart. Odd rows are shifted by half that, and rows are sqrt(3)/2
/// lengths apart.
class CoreLattice {
 public:
  /// Outer loops run counter-clockwise, holes clockwise; loop l is plane[loop_begin[l] .. loop_begin[l+1]).
  /// `area`: the area that the loops enclose. The result is empty if there is no room, or if the box of the
  /// loops is so much larger than the area that the loops enclose only a thin rim. Throws Interrupted.
  void build(std::span<const Vec2d> plane, std::span<const std::uint32_t> loop_begin, double length,
             double area, const Execution& execution = {});

  const std::vector<Vec2d>& points() const { return points_; }
  const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return triangles_; }  ///< ccw
  /// The rim as seen from the collar around the core (with the core on the right), in simple loops of indices
  /// of points(). Loop l begins at rim_begin()[l].
  const std::vector<std::uint32_t>& rim() const { return rim_; }
  const std::vector<std::uint32_t>& rim_begin() const { return rim_begin_; }

 private:
  /// A point of the lattice, possibly outside its rows and columns.
  struct Point {
    std::int64_t row, column;
  };

  bool lay_out(std::span<const Vec2d> plane, double length, double area);
  void mark_inside(std::span<const Vec2d> plane, std::span<const std::uint32_t> loop_begin, Pacer& pacer);
  void clear_near(const Vec2d& a, const Vec2d& b, Pacer& pacer);
  bool remove_pinches(const Execution& execution);
  void collect(Pacer& pacer);

  double x_of(std::int64_t row, std::int64_t column) const {
    return low_.x + (static_cast<double>(column) + ((row & 1) ? 0.5 : 0.0)) * length_;
  }
  double y_of(std::int64_t row) const { return low_.y + static_cast<double>(row) * height_; }
  std::size_t index(const Point& p) const { return static_cast<std::size_t>(p.row * columns_ + p.column); }
  bool usable(const Point& p) const {
    return p.row >= 0 && p.row < rows_ && p.column >= 0 && p.column < columns_ && usable_[index(p)];
  }
  static Point opposite(const Point& a, const Point& b, const Point& c);
  /// Calls visit(a, b, c), counter-clockwise, for every triangle whose corners are all usable.
  template <class Visit>
  void each_triangle(Pacer& pacer, const Visit& visit) const;

  Vec2d low_;
  double length_ = 1, height_ = 1;
  std::int64_t rows_ = 0, columns_ = 0;
  std::vector<char> usable_;           // per lattice point
  std::vector<std::uint32_t> number_;  // per lattice point: its index in points_
  std::vector<std::pair<double, int>> crossings_;
  std::vector<std::array<std::uint64_t, 2>> rim_edges_;  // directed, given by their start and end
  std::vector<Vec2d> points_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<std::uint32_t> rim_, rim_begin_;
};

}  // namespace fracture
