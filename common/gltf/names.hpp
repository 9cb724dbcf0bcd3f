// Names that every tool accepts: ASCII letters, digits and _, at most 63 bytes (Unreal and Blender both accept
// these).
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace fracture {

inline constexpr std::size_t kMaxName = 63;

/// Replaces disallowed bytes with _ and shortens the name to `room` bytes. Returns "mesh" for an empty name.
inline std::string ascii_name(std::string_view name, std::size_t room = kMaxName) {
  std::string result;
  for (const char c : name.substr(0, std::min(room, name.size()))) {
    const bool keep = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    result += keep ? c : '_';
  }
  return result.empty() ? "mesh" : result;
}

/// Returns the number with at least `width` digits.
inline std::string padded(std::size_t number, std::size_t width) {
  std::string digits = std::to_string(number);
  if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
  return digits;
}

/// Returns "<source>_007": the source node's name and the number, which makes it unique. At most `room` bytes.
inline std::string fragment_name(std::string_view source, std::size_t number, std::size_t count,
                                 std::size_t room = kMaxName) {
  const std::size_t width = std::to_string(count - 1).size();
  return ascii_name(source, room - 1 - width) + "_" + padded(number, width);
}

}  // namespace fracture
