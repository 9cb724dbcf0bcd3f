// The page that a browser gets (client/page), as the build put it into the program: compressed, under the names
// that the page itself uses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace fracture::page {

struct File {
  std::string_view path;        ///< "index.html", "docs.html", or what stands under /page/ without that
  std::string_view media_type;  ///< with its charset
  std::string_view digest;      ///< of the plain bytes, 16 hex digits: for an ETag
  std::span<const std::uint8_t> gzip;
  std::size_t plain_size;  ///< bytes
};

/// Empty where the server was built without the page: there was no node, or FRACTURE_PAGE was OFF.
std::span<const File> files();

/// Null where there is none.
const File* find(std::string_view path);

/// The plain bytes. Throws InternalError where they are damaged.
std::string plain(const File& file);

}  // namespace fracture::page
