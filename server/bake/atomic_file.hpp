// Files that are there whole or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace fracture::bake {

/// A temporary file beside the target (".<name>.part", used again by the next try), flushed to the disk, then
/// renamed over it. False with errno set.
bool write_file(const std::string& path, std::span<const std::byte> bytes);

/// Makes the folders that the path lies in. False with errno set.
bool make_folders_of(const std::string& path);

}  // namespace fracture::bake
