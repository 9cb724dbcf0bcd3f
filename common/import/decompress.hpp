// What some formats compress as a whole (.blend, .zgl), opened in our own code, so that the decoded size is
// bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/error.hpp"

namespace fracture {

bool is_gzip(std::span<const std::byte> bytes);
bool is_zstd(std::span<const std::byte> bytes);

/// A gzip (RFC 1952) or zlib (RFC 1950) stream; bytes that follow it are ignored. kTooLarge beyond
/// `max_bytes`, kMalformedMesh where the stream is damaged or ends early.
Expected<std::vector<std::byte>> inflate(std::span<const std::byte> bytes, std::uint64_t max_bytes);
/// Zstandard frames (RFC 8878), one after another as Blender 3 writes them. Errors as inflate().
Expected<std::vector<std::byte>> unzstd(std::span<const std::byte> bytes, std::uint64_t max_bytes);

}  // namespace fracture
