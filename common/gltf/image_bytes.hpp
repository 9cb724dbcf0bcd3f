// Images on their way into the file.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// What is written of an image, piece by piece: all its bytes, less those chunks of a PNG that state another colour space than sRGB's
/// (iCCP; gAMA and cHRM with other values) or pixels that are not square (pHYs). glTF 2.0 (3.8.3, images)
/// tells readers to ignore them, and the Khronos validator warns of them (IMAGE_FEATURES_UNSUPPORTED). The
/// pixels are untouched. A PNG that cannot be followed chunk by chunk stays as it is.
std::vector<std::span<const std::uint8_t>> image_pieces(std::span<const std::uint8_t> image, Pacer& pacer);

}  // namespace fracture
