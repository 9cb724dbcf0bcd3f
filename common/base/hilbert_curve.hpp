// The Hilbert curve through a lattice. Neighbours on the curve are neighbours in space, so elements that are
// stored in this order and used together are near each other in memory. Hamilton 2006, "Compact Hilbert
// indices", without the compaction.
#pragma once

#include <cstdint>

#include "common/base/vec.hpp"

namespace fracture {

/// Position on the Hilbert curve of a 2^bits lattice, coordinates below 2^bits, bits <= 21.
std::uint64_t hilbert_index(std::uint32_t x, std::uint32_t y, std::uint32_t z, int bits);

/// The curve through the cube over a box: 2^bits cells along the longest side. A box without size is one cell.
class HilbertCurve {
 public:
  HilbertCurve(const Box& box, int bits);

  /// Position on the curve of the cell that contains a point; a point outside the cube is moved to its
  /// nearest point.
  std::uint64_t at(const Vec3d& point) const;

 private:
  Vec3d corner_;
  double side_, last_cell_;
  int bits_;
};

}  // namespace fracture
