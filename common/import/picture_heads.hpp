// How large the pictures in a file are, by their heads: for those who give a reader the memory that it will need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fracture {

/// Pixels of the largest PNG or JPEG that begins anywhere in these bytes; 0 where none does. What only looks like a
/// head counts, too.
std::uint64_t largest_picture(std::span<const std::byte> bytes);

}  // namespace fracture
