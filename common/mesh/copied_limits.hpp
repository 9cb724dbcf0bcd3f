// Limits for data of the source that an answer repeats in each fragment.
#pragma once

#include <cstddef>
#include <string>

namespace fracture {

/// Maximum length of SourceNode::name, bytes.
inline constexpr std::size_t kMostNodeName = 256;

/// Maximum length of the mappings of a primitive (KHR_materials_variants), as JSON text. Each primitive of a fragment has a copy.
inline constexpr std::size_t kMostMappings = 4096;

/// Returns the name (UTF-8), cut to kMostNodeName bytes at the end of a character.
inline std::string node_name_within_limit(std::string name) {
  if (name.size() <= kMostNodeName) return name;
  std::size_t end = kMostNodeName;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
  name.resize(end);
  return name;
}

}  // namespace fracture
