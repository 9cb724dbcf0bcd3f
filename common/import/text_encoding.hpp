// Converts text in UTF-16, which some Windows tools write. Only text with a byte order mark is converted;
// other text is unchanged.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/base/utf8.hpp"

namespace fracture {

/// Returns the text in UTF-8 if it begins with a UTF-16 byte order mark, otherwise nothing. Lone surrogates
/// become U+FFFD.
inline std::optional<std::string> utf16_to_utf8(std::span<const std::byte> bytes) {
  if (bytes.size() < 2) return std::nullopt;
  const auto at = [&](std::size_t k) { return std::to_integer<unsigned>(bytes[k]); };
  const bool little = at(0) == 0xff && at(1) == 0xfe, big = at(0) == 0xfe && at(1) == 0xff;
  if (!little && !big) return std::nullopt;
  const auto unit = [&](std::size_t k) { return little ? at(k) | at(k + 1) << 8 : at(k) << 8 | at(k + 1); };
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t k = 2; k + 1 < bytes.size(); k += 2) {
    unsigned code = unit(k);
    const bool high = code >= 0xd800 && code < 0xdc00, low = code >= 0xdc00 && code < 0xe000;
    const unsigned next = high && k + 3 < bytes.size() ? unit(k + 2) : 0;
    if (high && next >= 0xdc00 && next < 0xe000) {
      code = 0x10000 + ((code - 0xd800) << 10) + (next - 0xdc00);
      k += 2;
    } else if (high || low) {
      code = 0xfffd;
    }
    if (code < 0x80) {
      text += static_cast<char>(code);
      continue;
    }
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;  // number of bytes after the first
    constexpr unsigned kFirst[] = {0, 0xc0, 0xe0, 0xf0};
    text += static_cast<char>(kFirst[more] | code >> 6 * more);
    for (int m = more - 1; m >= 0; --m) text += static_cast<char>(0x80 | (code >> 6 * m & 0x3f));
  }
  return text;
}

/// Returns a name that JSON can contain: invalid UTF-8 is interpreted as Latin-1, which old exporters write.
inline std::string name_as_utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      result += c;
    } else {
      result += static_cast<char>(0xc0 | byte >> 6);
      result += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return result;
}

}  // namespace fracture
