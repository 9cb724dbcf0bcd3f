// Makes names from files and clients safe to print in a terminal or a message.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fracture {

/// Maximum length of a quotation in a message, bytes: enough to recognize the text.
constexpr std::size_t kMostQuoted = 200;

/// Shortens a text to kMostQuoted bytes and appends "..." if it is longer. UTF-8 characters stay whole.
inline std::string shortened(std::string_view text) {
  if (text.size() <= kMostQuoted) return std::string(text);
  std::size_t end = kMostQuoted;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return std::string(text.substr(0, end)) + "...";
}

/// Writes control characters as \x1b, including those in U+0080 to U+009F, so that escape sequences or line
/// breaks in a name cannot pass for the program's output. `keep`: control characters to leave unchanged.
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

/// The same for messages that have several lines.
inline std::string printable_lines(std::string_view text) { return printable(text, "\n\t"); }

}  // namespace fracture
