// Uniform points in the volume of a closed surface, by columns.
//
// A column is a line along one axis. Picking a triangle through which columns enter, with probability
// proportional to its area projected along the axis, and a uniform point on it, picks an (entry, column) pair
// uniformly over the projection. The point then starts a chord: the stretch of the column with winding number
// >= 1 that begins at this entry. Keeping the candidate with probability chord / cap and then going a uniform
// share of the chord inwards gives points uniform in the volume as long as no chord is longer than the cap.
// (Entries into what is already inside, where parts overlap, are refused, so that overlaps count once.)
//
// The cap is the width of the box: exact. Only for solids so thin and slanted that fewer than one candidate
// in 64 would be kept it is the longest chord of 256 probes; the few longer chords then count as if they were
// that long.
//
// Crossings of a batch of columns with all triangles are found by streaming the triangles once over a grid of
// the columns, row by row of the grid: near-linear in triangles + crossings, and nothing is built for the
// mesh.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/random.hpp"
#include "common/solid/solid.hpp"

namespace fracture::sites_detail {

/// Coordinates across and along an axis: (u, v, axis) is right-handed.
struct ColumnFrame {
  explicit ColumnFrame(int along) : u((along + 1) % 3), v((along + 2) % 3), axis(along) {}
  int u, v, axis;
};

class ColumnSampler {
 public:
  /// Both are borrowed. Everything here throws Interrupted.
  ColumnSampler(const Solid& solid, std::uint64_t seed, const Execution& execution);

  /// `count` points: candidates in the order of their numbers, the kept ones. Each candidate draws from a
  /// generator of its own number, so batches do not show. After kPatience refusals in a row the next
  /// candidate is kept as it is, which bounds the work.
  std::vector<Vec3d> sample(std::uint32_t count);

  /// As many points, one less where rounding takes the last; none where no chord is found. The chords of two columns for
  /// each are laid end to end and divided into `count` parts, and each part has a point (stratified sampling, Neyman
  /// 1934). No candidate is refused: in a thin wall, where sample() refuses nearly all, these take less than half of its
  /// time. Several may lie on one column.
  std::vector<Vec3d> spread(std::uint32_t count);

  /// Which of these points lie in the solid (winding number at least 1). A point within rounding error of
  /// the surface may be told either way.
  std::vector<bool> inside(std::span<const Vec3d> points);

  static constexpr std::uint32_t kPatience = 4096;
  static constexpr std::size_t kCrossingsPerBatch = 1 << 20;
  /// Crossings looked at between two kept candidates, for columns through tangles: the next one is kept as
  /// well.
  static constexpr std::uint64_t kCrossingsPerPoint = 1 << 18;

  /// How often a triangle was compared with a column, so far: what the work grows with, beside the triangles.
  std::uint64_t comparisons() const { return comparisons_; }

 private:
  static constexpr std::size_t kAtOnce = 1024;  ///< vertices or triangles of a block of parallel work
  struct Column {
    std::uint32_t triangle;  ///< the entry
    double u, v;             ///< where the column stands, across the axis
    double keep, share;      ///< uniform in [0, 1)
  };
  struct Crossing {
    std::uint32_t column;
    double at;   ///< along the axis
    int enters;  ///< +1 into the solid, -1 out of it
    std::uint32_t triangle;
  };
  struct Chord {
    double begin = 0, length = -1;  ///< negative: none begins here
    std::uint32_t crossings = 0;    ///< of the whole column
  };
  /// What sample() and spread() need and inside() does not.
  void choose_axis();
  Column column(std::uint64_t stream, std::uint64_t number) const;
  /// The chord that begins at each column's entry.
  std::vector<Chord> chords(std::span<const Column> columns);
  /// Of columns along `axis`: by column, then along it. False where more than a few columns have more
  /// crossings than may be held at a time: then fewer columns should be asked about.
  bool cross_all(int axis, std::span<const Column> columns, std::vector<Crossing>& crossings);
  /// How many columns to ask about at a time.
  std::size_t batch() const { return std::max<std::size_t>(16, kCrossingsPerBatch / depth_); }
  Vec3d place(const Column& column, double along) const;
  double height_on_triangle(const Column& column) const;

  const Solid& solid_;
  const Execution& execution_;
  std::uint64_t seed_;
  int axis_ = 0;
  double cap_ = 0;
  double rate_ = 0.5;      ///< of candidates, how many are kept, about
  std::size_t depth_ = 8;  ///< crossings per column, in the last batch
  std::uint64_t comparisons_ = 0;
  std::vector<double> entry_area_;  ///< running sums over the triangles; empty until choose_axis()
};

}  // namespace fracture::sites_detail
