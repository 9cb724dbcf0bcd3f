// A cubic lattice around a box, whose points are multiples of its step.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "common/base/vec.hpp"

namespace fracture::hollow_detail {

class Lattice {
 public:
  /// At least one step wider than the box on every side.
  Lattice(const Box& box, double step) : step_(step) {
    for (int axis = 0; axis < 3; ++axis) {
      low_[axis] = std::floor(box.min[axis] / step) - 1;
      size_[axis] = static_cast<std::uint32_t>(std::ceil(box.max[axis] / step) + 1 - low_[axis]) + 1;
    }
  }
  std::uint32_t size(int axis) const { return size_[axis]; }
  /// Coordinate of the lowest points, m.
  double low(int axis) const { return step_ * low_[axis]; }
  std::uint32_t points() const { return size_[0] * size_[1] * size_[2]; }
  double step() const { return step_; }
  std::uint32_t at(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (z * size_[1] + y) * size_[0] + x;
  }
  /// The neighbour of this point in direction `bits` (x + 2y + 4z).
  std::uint32_t neighbour(std::uint32_t point, std::uint32_t bits) const {
    return point + (bits & 1) + (bits >> 1 & 1) * size_[0] + (bits >> 2 & 1) * size_[0] * size_[1];
  }
  Vec3d place(std::uint32_t point) const {
    const std::uint32_t x = point % size_[0], y = point / size_[0] % size_[1],
                        z = point / size_[0] / size_[1];
    return {step_ * (low_[0] + x), step_ * (low_[1] + y), step_ * (low_[2] + z)};
  }
  /// Calls visit(point) for the lowest corner of every cube.
  template <class Visit>
  void each_cube(const Visit& visit) const {
    for (std::uint32_t z = 0; z + 1 < size_[2]; ++z)
      for (std::uint32_t y = 0; y + 1 < size_[1]; ++y)
        for (std::uint32_t x = 0; x + 1 < size_[0]; ++x) visit(at(x, y, z));
  }

 private:
  double step_;
  std::array<double, 3> low_;
  std::array<std::uint32_t, 3> size_;
};

}  // namespace fracture::hollow_detail
