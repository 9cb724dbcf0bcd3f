// Prepares images for the file.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"

namespace fracture {

/// Returns the pieces of an image that are written: all bytes except some PNG chunks. These declare a colour space other than
/// sRGB (iCCP; gAMA and cHRM with other values) or pixels that are not square (pHYs). glTF 2.0 (3.8.3, images)
/// tells readers to ignore them, and the Khronos validator warns about them (IMAGE_FEATURES_UNSUPPORTED). The
/// pixels stay unchanged. A malformed PNG is copied from its first chunk that cannot be parsed.
std::vector<std::span<const std::uint8_t>> image_pieces(std::span<const std::uint8_t> image, Pacer& pacer);

}  // namespace fracture
