// Bits of floats such that equal numbers have equal bits.
#pragma once

#include <bit>
#include <cstdint>

namespace fracture {

/// Returns the bits of a float that is not NaN; -0 has the bits of 0.
inline std::uint32_t bits_of(float v) { return std::bit_cast<std::uint32_t>(v + 0.0f); }

}  // namespace fracture
