// The two kinds of uri that an uploaded file may contain: data uris, and names of other parts of the same
// upload.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/import/import_input.hpp"

namespace fracture {

bool is_data_uri(std::string_view uri);

struct DataUri {
  std::string media_type;  ///< "image/png"; empty if the uri has none
  std::vector<std::uint8_t> bytes;
};
/// Decodes RFC 2397 with base64 (RFC 4648 §4; missing padding is accepted). Returns nothing for any other
/// uri.
std::optional<DataUri> decode_data_uri(std::string_view uri);

/// Replaces "%20" etc. by the bytes that they represent. Other text is unchanged.
std::string decode_percent(std::string_view uri);

/// Returns the part with this name: the percent-decoded uri, without a leading "./". If there is none, the
/// part with the last component of the name, because browsers and curl send file names without their folder,
/// and tools write paths of the machine that they ran on. Finally, compares the last component without regard
/// to case, because most artists' file systems do the same. Returns null if none matches.
const ImportFile* find_file(std::span<const ImportFile> files, std::string_view uri);

}  // namespace fracture
