// Reads colours from KTX 2.0 textures (Khronos KTX File Format Specification 2.0.4): 8-bit RGB and RGBA, and UASTC whose
// smallest mip level is a block of one colour (Basis Universal UASTC specification, mode 8). Encoders store a level of 1 x 1
// in this way, and it is the mean of the whole texture.
#pragma once

#include "common/surface_color/pixels.hpp"

namespace fracture {

bool is_ktx2(std::span<const std::uint8_t> image);
/// Number of pixels that decode_ktx2() returns; nothing if it cannot decode the texture.
std::optional<std::uint64_t> ktx2_pixel_count(std::span<const std::uint8_t> ktx2);
/// Why decode_ktx2() does not read this encoding, after "because it "; null if it does, or if the file is damaged.
const char* why_ktx2_is_unread(std::span<const std::uint8_t> ktx2);
/// The largest level with at most 2^20 pixels; a single pixel for UASTC. Nothing if the file is damaged or its encoding is
/// not read. Throws std::bad_alloc.
std::optional<Pixels> decode_ktx2(std::span<const std::uint8_t> ktx2);

}  // namespace fracture
