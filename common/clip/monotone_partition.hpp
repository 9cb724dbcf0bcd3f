// The plane sweep that joins holes to their outer rings and splits rings into y-monotone pieces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/triangulate.hpp"

namespace fracture {

struct Partition {
  /// Rings of point indices, one after the other; ring r is [ring_begin[r], ring_begin[r + 1]).
  std::vector<std::uint32_t> ring_points;
  std::vector<std::uint32_t> ring_begin;
  std::size_t count() const { return ring_begin.size() - 1; }
  std::span<const std::uint32_t> ring(std::size_t r) const {
    return {ring_points.data() + ring_begin[r], ring_begin[r + 1] - ring_begin[r]};
  }
  std::vector<std::uint32_t>
      ring_loop;  ///< a representative input loop: equal for rings of one connected region
  std::vector<std::uint32_t> unnested;  ///< clockwise loops that found no outer ring
  /// How often edges that met beside each other in the sweep crossed by more than rounding explains; only
  /// looked for among kManyPoints points and more.
  std::uint32_t crossings = 0;
  static constexpr std::size_t kManyPoints = 1024;
};

/// Each diagonal of the partition is used once in each direction by the rings, each loop edge once. Throws
/// Interrupted.
void partition_monotone(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                        Partition& out, const Execution& execution = kUninterrupted);

}  // namespace fracture
