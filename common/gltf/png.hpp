// PNG out (ISO/IEC 15948): 8-bit RGB, for the few images that are made and not passed through.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace fracture {

/// `pixels`: width * height, rows from the top.
std::vector<std::uint8_t> write_png(std::span<const std::array<std::uint8_t, 3>> pixels, std::uint32_t width,
                                    std::uint32_t height);

}  // namespace fracture
