// Many colours as few: which of them look alike.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace fracture {

struct ColorGroups {
  std::vector<LinearColor> means;  ///< by weight, the heaviest group first
  /// The group of a colour that was added.
  std::uint32_t of(const LinearColor& color) const;

  std::vector<std::uint32_t> of_bin;  ///< [bin]; what has no colour in it: 0
};

/// Colours with weights, in bins: however many there are, they take the same memory. Steps are of the square root of
/// linear light, in which equal ones look about equal.
class ColorHistogram {
 public:
  ColorHistogram();
  /// `weight` > 0.
  void add(const LinearColor& color, double weight);
  bool empty() const { return sums_.empty(); }
  void clear();

  /// At most `most` groups, and none is divided whose colours differ by at most `alike`, 0 … 1, along each axis.
  /// Heckbert 1982, "Color Image Quantization for Frame Buffer Display" (median cut), with the group of the largest
  /// variance divided first, at its mean.
  ColorGroups groups(std::size_t most, double alike) const;

 private:
  struct Sum {
    std::uint32_t bin;
    std::array<double, 3> color{};
    double weight = 0;
  };
  std::vector<Sum> sums_;             ///< of the bins with colours, in the order in which they came
  std::vector<std::uint16_t> place_;  ///< [bin]: 1 + its place in `sums_`; 0: without colours
};

}  // namespace fracture
