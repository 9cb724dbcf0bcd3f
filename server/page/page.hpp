// The browser page (client/page), which the build embeds in the program under the names that the page uses.
// Each file is embedded both compressed and plain, so that no request waits for compression. Files that are
// never requested are not loaded from disk.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace fracture::page {

struct File {
  std::string_view path;        ///< "index.html", "docs.html", or the path below /page/
  std::string_view media_type;  ///< including its charset
  std::string_view digest;      ///< 16 hex digits of the digest of `plain`, for an ETag
  std::span<const std::uint8_t> gzip, plain;
};

/// Returns all files. Empty if the server was built without the page: npm was missing, or FRACTURE_PAGE was
/// OFF.
std::span<const File> files();

/// Returns null if there is no such file.
const File* find(std::string_view path);

}  // namespace fracture::page
