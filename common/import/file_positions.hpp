// The positions in a file of text or doubles, before they become floats. Survey coordinates (500000, 30, 4649776) have steps
// of half a metre as floats. So positions are read as doubles, and one offset for the whole file is subtracted before they are
// rounded.
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture {

/// The offset for coordinates in this box: zero, unless rounding them to floats can move them by more than a millionth of the
/// box's longest side. Otherwise, the box's centre, rounded to multiples of a power of two that is at least the longest side.
/// Each coordinate of the offset is a float. It depends on nothing but the box.
Vec3d offset_for(const Box& box);

class FilePositions {
 public:
  void add(const Vec3d& position) { positions_.push_back(position); }
  std::size_t size() const { return positions_.size(); }
  const Vec3d& operator[](std::size_t index) const { return positions_[index]; }

  /// Whether a float can have this value: it is a number, and not too large.
  static bool fits(const Vec3d& position);

  /// Marks a position as part of the surface. Only such positions determine the offset, because files contain points that no
  /// face uses. Requires fits().
  void use(std::size_t index) { used_.add(positions_[index]); }

  /// The offset of the positions in use.
  Vec3d offset() const { return offset_for(used_); }
  /// All positions less the offset, each rounded once to floats. Without an offset (zero), these are the floats nearest to the
  /// doubles. Positions that do not fit become zero.
  std::vector<Vec3f> rounded(const Vec3d& offset) const;

 private:
  std::vector<Vec3d> positions_;
  Box used_;
};

}  // namespace fracture
