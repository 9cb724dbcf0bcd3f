// Files that are there whole or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>

namespace fracture::bake {

/// A temporary file beside the target (".<name>.part", used again by the next try), flushed to the disk, then
/// renamed over it. False with errno set.
bool write_file(const std::string& path, std::span<const std::byte> bytes);

/// All of it, or false with errno set: EPIPE where nobody reads any more, which is no signal here; ECANCELED
/// where the stop came while nobody read.
bool write_standard_output(std::span<const std::byte> bytes, const std::stop_token& stop);

/// Makes the folders that the path lies in. False with errno set.
bool make_folders_of(const std::string& path);

}  // namespace fracture::bake
