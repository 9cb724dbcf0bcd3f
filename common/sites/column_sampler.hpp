// Samples uniform points in the volume of a closed surface, by columns.
//
// A column is a line along one axis. To choose an entry and a column, pick a triangle through which columns
// enter, with probability proportional to its area projected along the axis, and then a uniform point on this
// triangle. This is uniform over the projection. The entry begins a chord: the stretch of the column with
// winding number >= 1. The candidate is kept with probability chord / cap, and the point is a uniform share
// of the chord inwards. The points are uniform in the volume if no chord is longer than the cap. (Entries
// into regions that are already inside, where parts overlap, are refused, so overlaps count once.)
//
// The cap is the width of the box, which makes the method exact. If a solid is so thin and slanted that fewer
// than one candidate in 64 would be kept, the cap is the longest chord of 256 probes. The few longer chords
// then count as if they had that length.
//
// To find the crossings of a batch of columns, the triangles are streamed once over a grid of the columns,
// row by row. This is near-linear in triangles + crossings, and no structure is built for the mesh.
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
  /// Both references are borrowed. All member functions throw Interrupted.
  ColumnSampler(const Solid& solid, std::uint64_t seed, const Execution& execution);

  /// Returns `count` points: the kept candidates in the order of their numbers. Each candidate draws from its
  /// own generator, so the batch size does not affect the points. After kPatience refusals in a row, the next
  /// candidate is kept unconditionally, which bounds the work.
  std::vector<Vec3d> sample(std::uint32_t count);

  /// Returns `count` points, or one fewer if rounding loses the last. Returns none if no chord is found. The
  /// chords of 2 · count columns are laid end to end and divided into `count` parts, and each part gets one
  /// point (stratified sampling, Neyman 1934). No candidate is refused: in a thin wall, where sample()
  /// refuses nearly all candidates, this takes less than half the time. Several points may share a column.
  std::vector<Vec3d> spread(std::uint32_t count);

  /// Whether each of these points is in the solid (winding number at least 1). A point within rounding error
  /// of the surface may get either result.
  std::vector<bool> inside(std::span<const Vec3d> points);

  static constexpr std::uint32_t kPatience = 4096;
  static constexpr std::size_t kCrossingsPerBatch = 1 << 20;
  /// Maximum number of crossings tested between two kept candidates, for columns through tangled surfaces.
  /// Beyond it, the next candidate is also kept unconditionally.
  static constexpr std::uint64_t kCrossingsPerPoint = 1 << 18;

  /// Number of comparisons of a triangle with a column so far. This and the number of triangles determine the
  /// running time.
  std::uint64_t comparisons() const { return comparisons_; }

 private:
  static constexpr std::size_t kAtOnce = 1024;  ///< vertices or triangles in one block of parallel work
  struct Column {
    std::uint32_t triangle;  ///< the entry
    double u, v;             ///< position of the column across the axis
    double keep, share;      ///< uniform in [0, 1)
  };
  struct Crossing {
    std::uint32_t column;
    double at;   ///< along the axis
    int enters;  ///< +1 into the solid, -1 out of it
    std::uint32_t triangle;
  };
  struct Chord {
    double begin = 0, length = -1;  ///< negative if no chord begins here
    std::uint32_t crossings = 0;    ///< number on the whole column
  };
  /// Computes data that sample() and spread() need but inside() does not.
  void choose_axis();
  Column column(std::uint64_t stream, std::uint64_t number) const;
  /// The chord that begins at each column's entry.
  std::vector<Chord> chords(std::span<const Column> columns);
  /// Finds the crossings of columns along `axis`, sorted by column and then along it. Returns false if there
  /// are more crossings than may be held at once; the caller should then pass fewer columns. Batches of at
  /// most 16 columns never fail.
  bool cross_all(int axis, std::span<const Column> columns, std::vector<Crossing>& crossings);
  /// Number of columns to pass at a time.
  std::size_t batch() const { return std::max<std::size_t>(16, kCrossingsPerBatch / depth_); }
  Vec3d place(const Column& column, double along) const;
  double height_on_triangle(const Column& column) const;

  const Solid& solid_;
  const Execution& execution_;
  std::uint64_t seed_;
  int axis_ = 0;
  double cap_ = 0;
  double rate_ = 0.5;      ///< estimated share of the candidates that are kept
  std::size_t depth_ = 8;  ///< crossings per column in the last batch
  std::uint64_t comparisons_ = 0;
  std::vector<double> entry_area_;  ///< running sums over the triangles; empty until choose_axis()
};

}  // namespace fracture::sites_detail
