#include "common/import/formats.hpp"

#include <algorithm>
#include <array>

namespace fracture {
namespace {

using enum FormatEncoding;
using enum FormatFrame;
using enum FormatReader;

constexpr FormatInfo kFormats[] = {
#define FRACTURE_MESH_FORMAT(enumerator, name, extensions, media, magic, encoding, frame, reader, on, none) \
  {MeshFormat::enumerator, name, extensions, media, magic, encoding, frame, reader, on, none},
#include "common/import/formats.def"
#undef FRACTURE_MESH_FORMAT
};

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return lower(x) == lower(y); });
}

/// Whether the word is in the list, which is separated by blanks.
bool contains(std::string_view list, std::string_view word) {
  while (!list.empty()) {
    const std::string_view next = list.substr(0, list.find(' '));
    if (equal_ignoring_case(next, word)) return true;
    list.remove_prefix(std::min(list.size(), next.size() + 1));
  }
  return false;
}

}  // namespace

std::span<const FormatInfo> all_formats() { return kFormats; }

const FormatInfo& format_info(MeshFormat format) { return kFormats[static_cast<std::size_t>(format)]; }

std::optional<MeshFormat> format_from_extension(std::string_view extension) {
  for (const FormatInfo& f : kFormats)
    if (equal_ignoring_case(extension, f.name) || contains(f.extensions, extension)) return f.format;
  return std::nullopt;
}

std::optional<MeshFormat> format_from_media_type(std::string_view media_type) {
  media_type = media_type.substr(0, media_type.find(';'));
  while (!media_type.empty() && media_type.back() == ' ') media_type.remove_suffix(1);
  for (const FormatInfo& f : kFormats)
    if (contains(f.media_types, media_type)) return f.format;
  return std::nullopt;
}

std::optional<MeshFormat> format_from_content(std::span<const std::byte> bytes) {
  constexpr std::size_t kSeen = 4096;
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kSeen));
  if (text.substr(0, 4) == "FORM") {  // EA IFF 85: the length, then the kind of form
    const std::string_view kind = text.size() >= 12 ? text.substr(8, 4) : "";
    if (kind == "LWO2" || kind == "LWOB" || kind == "LWLO") return MeshFormat::kLwo;
    if (kind == "LXOB") return MeshFormat::kLxo;
    return std::nullopt;
  }
  if (text.substr(0, 2) == "MM") {  // the main chunk spans the whole file
    std::uint64_t length = 0;
    for (std::size_t k = 6; k-- > 2 && text.size() >= 6;)
      length = length << 8 | static_cast<unsigned char>(text[k]);
    return length >= 6 && length <= bytes.size() ? std::optional(MeshFormat::k3ds) : std::nullopt;
  }
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (text.substr(0, 4) == "ply\r") return MeshFormat::kPly;
  if (equal_ignoring_case(text.substr(0, 6), "solid ")) return MeshFormat::kStl;
  const std::size_t off = text.find_first_not_of("STCN4n");  // what precedes OFF says what its vertices have
  if (off != std::string_view::npos && off <= 6 && text.substr(off, 3) == "OFF") return MeshFormat::kOff;
  for (const FormatInfo& f : kFormats)
    if (!f.magic.empty() && text.substr(0, f.magic.size()) == f.magic) return f.format;
  return std::nullopt;
}

}  // namespace fracture
