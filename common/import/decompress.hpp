// Decompresses files that some formats compress as a whole (.blend, .zgl). This project's code does it, so
// that the decoded size is limited.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/error.hpp"

namespace fracture {

bool is_gzip(std::span<const std::byte> bytes);
bool is_zstd(std::span<const std::byte> bytes);

/// Decompresses a gzip (RFC 1952) or zlib (RFC 1950) stream; bytes after it are ignored. Errors: kTooLarge
/// beyond `max_bytes`, kMalformedMesh if the stream is damaged or ends early.
Expected<std::vector<std::byte>> inflate(std::span<const std::byte> bytes, std::uint64_t max_bytes);
/// Decompresses a deflate stream (RFC 1951) without header, as in ZIP archives. Errors as inflate().
Expected<std::vector<std::byte>> inflate_raw(std::span<const std::byte> bytes, std::uint64_t max_bytes);
/// Decompresses concatenated Zstandard frames (RFC 8878), as written by Blender 3. Errors as inflate().
Expected<std::vector<std::byte>> unzstd(std::span<const std::byte> bytes, std::uint64_t max_bytes);

}  // namespace fracture
