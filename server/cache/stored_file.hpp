// Files in a folder of the server, for example cache entries. Somebody else may have put anything in their places.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/descriptor.hpp"
#include "common/base/execution.hpp"

namespace fracture {

struct StoredFile {
  Descriptor file;
  std::uint64_t size = 0;  ///< bytes
};

/// Opens a regular file for reading, without waiting. Returns nothing on failure and sets errno, which is EINVAL if something
/// else has this name: a FIFO, a device, a folder, or a link.
std::optional<StoredFile> open_stored(const std::string& path);

/// Returns the next `size` bytes of the file, or fewer if it ends before. Returns nothing if it cannot be read; errno gives
/// the reason. Polls between pieces. Throws Interrupted.
std::optional<std::vector<std::uint8_t>> read_bytes(const StoredFile& stored, std::uint64_t size,
                                                    const Execution& execution = kUninterrupted);

}  // namespace fracture
