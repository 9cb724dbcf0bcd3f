// The two kinds of uri an uploaded file may hold: data uris, and names of other parts of the same upload.
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
  std::string media_type;  ///< "image/png"; empty where the uri names none
  std::vector<std::uint8_t> bytes;
};
/// RFC 2397 with base64 (RFC 4648 §4; missing padding is accepted). Nothing where it is not that.
std::optional<DataUri> decode_data_uri(std::string_view uri);

/// "%20" and the like as the bytes they stand for; what is no escape stays.
std::string decode_percent(std::string_view uri);

/// The part with this name: the uri percent-decoded, a leading "./" ignored. Where there is none, the part
/// with the name's last component: browsers and curl send file names without their folder, and tools write
/// paths of the machine they ran on; ignoring case at last, as on the machines of most artists. Null where
/// there is none either.
const ImportFile* find_file(std::span<const ImportFile> files, std::string_view uri);

}  // namespace fracture
