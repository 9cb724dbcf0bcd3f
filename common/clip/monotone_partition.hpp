// The plane sweep that joins holes to their outer rings and splits rings into y-monotone pieces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/clip/triangulate.hpp"

namespace fracture {

struct Partition {
  /// Rings of point indices, one after the other; ring r is [ring_begin[r], ring_begin[r + 1]).
  std::vector<std::uint32_t> ring_points;
  std::vector<std::uint32_t> ring_begin;
  std::vector<std::uint32_t>
      ring_loop;  ///< a representative input loop: equal for rings of one connected region
  std::vector<std::uint32_t> unnested;  ///< clockwise loops that found no outer ring
};

/// Each diagonal of the partition is used once in each direction by the rings, each loop edge once.
void partition_monotone(std::span<const LatticePoint> points, std::span<const std::uint32_t> loop_begin,
                        Partition& out);

}  // namespace fracture
