// The number types of glTF files, by name (glTF 2.0, section 3.6.2.2), for code that reads or writes such
// files.
#pragma once

#include <cstdint>

namespace fracture {

/// Values of accessor.componentType.
namespace component_type {
inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
                     kUnsignedInt = 5125, kFloat = 5126;
}

/// Size of a component type; 0 if there is no such type.
constexpr std::uint64_t component_bytes(std::uint64_t type) {
  using namespace component_type;
  switch (type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

/// Whether indices may have this type.
constexpr bool is_index_type(std::uint64_t type) {
  using namespace component_type;
  return type == kUnsignedByte || type == kUnsignedShort || type == kUnsignedInt;
}

}  // namespace fracture
