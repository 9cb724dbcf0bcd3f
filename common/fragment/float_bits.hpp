// Places that are equal as numbers are equal as bits.
#pragma once

#include <bit>
#include <cstdint>

namespace fracture {

/// Of a float that is no NaN; -0 has the bits of 0.
inline std::uint32_t bits_of(float v) { return std::bit_cast<std::uint32_t>(v + 0.0f); }

}  // namespace fracture
