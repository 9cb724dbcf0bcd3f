// Finds the size of the pictures in a file from their headers, to determine how much memory a reader will
// need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/base/execution.hpp"

namespace fracture {

/// Number of pixels of the largest PNG or JPEG that begins anywhere in these bytes; 0 if there is none. Bytes
/// that only look like a header also count. The time is linear in their number, whatever they are. Polls once
/// per kBytesBetweenPolls. Throws Interrupted.
std::uint64_t largest_picture(std::span<const std::byte> bytes, const Execution& execution = kUninterrupted);

}  // namespace fracture
