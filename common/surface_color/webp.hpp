// Decodes still WebP images with libwebp, whose decoder gives the same pixels on every machine.
#pragma once

#include "common/surface_color/pixels.hpp"

namespace fracture {

bool is_webp(std::span<const std::uint8_t> image);
/// Number of pixels that the header declares; nothing if it is damaged or declares an animation.
std::optional<std::uint64_t> webp_pixel_count(std::span<const std::uint8_t> webp);
/// Nothing if the image is damaged. Throws std::bad_alloc.
std::optional<Pixels> decode_webp(std::span<const std::uint8_t> webp);

}  // namespace fracture
