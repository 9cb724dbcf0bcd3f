// The page that a browser gets (client/page), as the build put it into the program, under the names that the page
// itself uses. Each file is there compressed and as it is, so that neither is made while somebody waits: what is
// never asked for stays on the disk with the rest of the program.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace fracture::page {

struct File {
  std::string_view path;        ///< "index.html", "docs.html", or what stands under /page/ without that
  std::string_view media_type;  ///< with its charset
  std::string_view digest;      ///< of the plain bytes, 16 hex digits: for an ETag
  std::span<const std::uint8_t> gzip, plain;
};

/// Empty where the server was built without the page: there was no node, or FRACTURE_PAGE was OFF.
std::span<const File> files();

/// Null where there is none.
const File* find(std::string_view path);

}  // namespace fracture::page
