// Writes PNG images (ISO/IEC 15948) with 8-bit RGB. Only generated images are written; the source's images are copied.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace fracture {

/// `pixels`: width * height of them, top row first.
std::vector<std::uint8_t> write_png(std::span<const std::array<std::uint8_t, 3>> pixels, std::uint32_t width,
                                    std::uint32_t height);

}  // namespace fracture
