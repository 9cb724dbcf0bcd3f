// Files that are on the disk when the call returns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fracture {

/// Writes `head` and the parts to `temporary`, flushes it to the disk, renames it to `path` and flushes the
/// folder of that. False with errno set; then neither file is there.
bool write_durably(const std::string& temporary, const std::string& path, std::string_view head,
                   std::span<const std::span<const std::byte>> parts);

/// The whole file. Nothing with errno set; EFBIG when it has more than `most` bytes, of which none is read.
std::optional<std::vector<std::uint8_t>> read_whole(const std::string& path, std::uint64_t most);

}  // namespace fracture
