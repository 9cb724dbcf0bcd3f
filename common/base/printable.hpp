// What files and strangers call things, for a terminal and a line of a message.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fracture {

/// Of a text that a message quotes: enough to know it again.
constexpr std::size_t kMostQuoted = 200;

/// At most kMostQuoted bytes, with "..." where that is not all of it. Characters of UTF-8 stay whole.
inline std::string shortened(std::string_view text) {
  if (text.size() <= kMostQuoted) return std::string(text);
  std::size_t end = kMostQuoted;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return std::string(text.substr(0, end)) + "...";
}

/// Control characters as \x1b, those of Unicode's second set (U+0080 to U+009F) too: a name with escape sequences or line
/// breaks in it cannot speak for the program. `keep`: controls that stay as they are.
inline std::string printable(std::string_view text, std::string_view keep = {}) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string result;
  result.reserve(text.size());
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    const bool second =
        byte == 0xC2 && k + 1 < text.size() && (static_cast<unsigned char>(text[k + 1]) & 0xE0) == 0x80;
    const bool control = byte < 0x20 || byte == 0x7F || second;
    if (!control || keep.find(text[k]) != std::string_view::npos) {
      result += text[k];
      continue;
    }
    const unsigned shown = second ? static_cast<unsigned char>(text[++k]) : byte;
    ((result += "\\x") += kDigits[shown >> 4]) += kDigits[shown & 15];
  }
  return result;
}

/// The same for messages of several lines.
inline std::string printable_lines(std::string_view text) { return printable(text, "\n\t"); }

}  // namespace fracture
