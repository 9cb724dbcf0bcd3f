// Text in UTF-8 according to RFC 3629 (no overlong forms, no surrogates).
#pragma once

#include <cstddef>
#include <string_view>

namespace fracture {

/// Returns the length of the text's first character, 1 to 4 bytes; 0 if the text is empty or begins with bytes that are not UTF-8.
inline std::size_t first_character(std::string_view text) {
  const auto byte = [&](std::size_t at) {
    return static_cast<unsigned char>(at < text.size() ? text[at] : 0);
  };
  if (text.empty()) return 0;
  const unsigned first = byte(0), second = byte(1);
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xc2 ? 0
                             : first < 0xe0 ? 2
                             : first < 0xf0 ? 3
                             : first < 0xf5 ? 4
                                            : 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(k) & 0xc0) != 0x80) return 0;
  const bool overlong_or_surrogate = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
                                     (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
  return overlong_or_surrogate ? 0 : length;
}

/// Whether the whole text is UTF-8.
inline bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = first_character(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

/// Returns the code point of a character: of the 1 to 4 bytes that first_character() counts.
inline char32_t code_point(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first;
  char32_t code = first & (0x7fu >> character.size());
  for (const char c : character.substr(1)) code = code << 6 | (static_cast<unsigned char>(c) & 0x3fu);
  return code;
}

}  // namespace fracture
