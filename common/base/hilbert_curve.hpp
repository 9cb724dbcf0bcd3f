// The Hilbert curve through a lattice: neighbours on it are neighbours in space, so that what is stored in its
// order and used together lies together. Hamilton 2006, "Compact Hilbert indices", without the compaction.
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

  /// Position on the curve of the cell that a point lies in; a point outside counts as the nearest in the cube.
  std::uint64_t at(const Vec3d& point) const;

 private:
  Vec3d corner_;
  double side_, last_cell_;
  int bits_;
};

}  // namespace fracture
