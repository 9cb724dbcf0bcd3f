// Numbers in binary files, in either byte order.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace fracture {

enum class ByteOrder { kLittle, kBig };

/// Reads `size` bytes (1 to 8) at `at` as an unsigned number. They must exist.
inline std::uint64_t unsigned_at(std::span<const std::byte> bytes, std::size_t at, std::size_t size,
                                 ByteOrder order) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < size; ++k) {
    const std::size_t next = order == ByteOrder::kLittle ? size - 1 - k : k;
    value = value << 8 | std::to_integer<std::uint64_t>(bytes[at + next]);
  }
  return value;
}

/// Reads an IEEE 754 single at `at`.
inline float float_at(std::span<const std::byte> bytes, std::size_t at, ByteOrder order) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(unsigned_at(bytes, at, 4, order)));
}

}  // namespace fracture
