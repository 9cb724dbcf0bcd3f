// gzip with a limit: Blender writes .blend files compressed when asked to, and Assimp would inflate any size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/error.hpp"

namespace fracture {

bool is_gzip(std::span<const std::byte> bytes);
/// The inflated bytes. kMalformedMesh, kTooLarge (beyond max_bytes; stops there).
Expected<std::vector<std::byte>> gunzip(std::span<const std::byte> bytes, std::uint64_t max_bytes);

}  // namespace fracture
