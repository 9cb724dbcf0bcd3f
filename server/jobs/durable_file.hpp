// Files that are completely on disk when the call returns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fracture {

/// Writes `head` and the parts to `temporary`, flushes it to disk, renames it to `path`, and flushes the
/// folder of `path`. Only the server's user can read the file, because jobs name clients and contain their
/// meshes. Returns false and sets errno on failure; `temporary` is then deleted.
bool write_durably(const std::string& temporary, const std::string& path, std::string_view head,
                   std::span<const std::span<const std::byte>> parts);

/// Reads a whole regular file (open_stored). On failure returns nothing and sets errno, which is EFBIG if the
/// file has more than `most` bytes.
std::optional<std::vector<std::uint8_t>> read_whole(const std::string& path, std::uint64_t most);

}  // namespace fracture
