// An image at successively halved sizes, where each texel is the mean of the pixels that it represents.
// Williams 1983, "Pyramidal Parametrics". Means use linear light and integers, so they are the same on every
// machine.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/surface_color/pixels.hpp"

namespace fracture {

/// Converts an sRGB byte (IEC 61966-2-1) to linear light.
std::uint16_t linear_light(std::uint8_t srgb);

class MeanPyramid {
 public:
  /// `weigh_opacity`: pixels are weighted by their opacity; otherwise opacity is ignored.
  MeanPyramid(Pixels pixels, bool weigh_opacity);

  std::uint32_t width() const { return image_.width(); }
  std::uint32_t height() const { return image_.height(); }
  /// Level 0 is the image; the last level is a single pixel.
  std::size_t levels() const { return 1 + means_.size(); }

  struct Texel {
    LinearColor color;
    std::uint16_t weight;  ///< 1 … 256: mean weight of its pixels
  };
  /// The texel that represents the pixel (x, y) of the image on that level; x < width(), y < height().
  Texel over(std::size_t level, std::uint32_t x, std::uint32_t y) const {
    return at(level, x >> level, y >> level);
  }

 private:
  struct Level {
    std::uint32_t width, height;
    std::vector<Texel> texels;
  };
  Texel at(std::size_t level, std::uint32_t x, std::uint32_t y) const;
  Level half_of(std::size_t level) const;

  Pixels image_;
  bool weigh_opacity_;
  std::vector<Level> means_;
};

}  // namespace fracture
