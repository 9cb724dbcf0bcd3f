// Reads ZIP archives (PKWARE APPNOTE 6.3.10), including ZIP64, which some printing programs write for every file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"

namespace fracture {

/// A file in an archive.
struct ZipEntry {
  std::string_view name;               ///< borrowed from the archive
  std::uint64_t header = 0;            ///< position of its local header
  std::uint64_t packed = 0, size = 0;  ///< bytes in the archive, and after decompression
  std::uint16_t flags = 0, method = 0;
  std::uint32_t crc = 0;
};

/// Reads the directory of an archive. Errors: kMalformedMesh if it is not complete, kTooLarge if its files declare more than
/// `max_bytes` in total. Linear in the archive.
Expected<std::vector<ZipEntry>> read_zip_directory(std::span<const std::byte> archive,
                                                   std::uint64_t max_bytes);

/// Decompresses one file, which may have at most `max_bytes`. Errors: kMalformedMesh if it is damaged, kTooLarge,
/// kUnsupportedFeature if it is encrypted or neither stored nor deflated.
Expected<std::vector<std::byte>> unzip(std::span<const std::byte> archive, const ZipEntry& entry,
                                       std::uint64_t max_bytes);

}  // namespace fracture
