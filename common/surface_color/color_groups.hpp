// Reduces many colours to a few groups of similar colours.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace fracture {

struct ColorGroups {
  std::vector<LinearColor> means;  ///< sorted by weight, the heaviest group first
  /// The group of a colour that was added.
  std::uint32_t of(const LinearColor& color) const;

  std::vector<std::uint32_t> of_bin;  ///< [bin]; 0 for bins without colours
};

/// Weighted colours in bins, so memory does not depend on their number. Bins have equal steps in the square
/// root of linear light, in which equal steps look about equal.
class ColorHistogram {
 public:
  ColorHistogram();
  /// `weight` must be positive.
  void add(const LinearColor& color, double weight);
  bool empty() const { return sums_.empty(); }
  void clear();

  /// Divides the colours into at most `most` groups. A group is not divided if its colours differ by at most
  /// `alike`, 0 … 1, along each axis. Heckbert 1982, "Color Image Quantization for Frame Buffer Display"
  /// (median cut), except that the group with the largest variance is divided first, at its mean.
  ColorGroups groups(std::size_t most, double alike) const;

 private:
  struct Sum {
    std::uint32_t bin;
    std::array<double, 3> color{};
    double weight = 0;
  };
  std::vector<Sum> sums_;             ///< for bins with colours, in order of first use
  std::vector<std::uint16_t> place_;  ///< [bin]: 1 + its index in `sums_`; 0: without colours
};

}  // namespace fracture
