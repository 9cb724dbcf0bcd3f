// A plane sweep that joins holes to their outer rings and divides rings into y-monotone pieces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

struct Partition {
  /// Rings of point indices, concatenated; ring r is [ring_begin[r], ring_begin[r + 1]).
  std::vector<std::uint32_t> ring_points;
  std::vector<std::uint32_t> ring_begin;
  std::size_t count() const { return ring_begin.size() - 1; }
  std::span<const std::uint32_t> ring(std::size_t r) const {
    return {ring_points.data() + ring_begin[r], ring_begin[r + 1] - ring_begin[r]};
  }
  /// A representative input loop: equal for all rings of one connected region
  std::vector<std::uint32_t> ring_loop;
  std::vector<std::uint32_t> unnested;  ///< clockwise loops without an outer ring
  /// Number of crossings, beyond rounding errors, of edges that were neighbours in the sweep. Counted only if
  /// there are at least kManyPoints points.
  std::uint32_t crossings = 0;
  static constexpr std::size_t kManyPoints = 1024;
};

/// Partitions the loops. The rings use each diagonal of the partition once in each direction, and each loop
/// edge once. Throws Interrupted.
void partition_monotone(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                        Partition& out, const Execution& execution = kUninterrupted);

}  // namespace fracture
