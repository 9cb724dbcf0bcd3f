// The number types of a glTF file, by name (glTF 2.0, section 3.6.2.2): for those who read such files, and for
// those who write them.
#pragma once

#include <cstdint>

namespace fracture {

/// Values of accessor.componentType.
namespace component_type {
inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
                     kUnsignedInt = 5125, kFloat = 5126;
}

/// 0: there is no such type.
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

/// May indices be of this type?
constexpr bool is_index_type(std::uint64_t type) {
  using namespace component_type;
  return type == kUnsignedByte || type == kUnsignedShort || type == kUnsignedInt;
}

}  // namespace fracture
