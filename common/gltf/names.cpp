#include "common/gltf/names.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "common/base/pacer.hpp"
#include "common/base/utf8.hpp"

namespace fracture {
namespace {

/// Code points beyond ASCII, first and last, that are controls, white space, or marks that change the direction of text. Joiners
/// (U+200C, U+200D) are kept, because Persian, Indic scripts and emoji need them.
constexpr std::array<std::array<char32_t, 2>, 9> kReplaced{{{0x80, 0xa0},
                                                            {0x1680, 0x1680},
                                                            {0x2000, 0x200b},
                                                            {0x200e, 0x200f},
                                                            {0x2028, 0x202f},
                                                            {0x205f, 0x206f},
                                                            {0x3000, 0x3000},
                                                            {0xfeff, 0xfeff},
                                                            {0xfff9, 0xffff}}};

bool is_kept(char32_t code) {
  if (code < 0x80)
    return (code >= 'a' && code <= 'z') || (code >= 'A' && code <= 'Z') || (code >= '0' && code <= '9') ||
           code == '_' || code == '-';
  return std::none_of(kReplaced.begin(), kReplaced.end(),
                      [&](const auto& range) { return code >= range[0] && code <= range[1]; });
}

/// Whether Godot would treat a node with this name, and a number after it, as more than a mesh. Its import hints are case-insensitive,
/// after - or _, and may be followed by a number (Godot 4.5, "Node type customization using name suffixes").
bool is_import_hint(std::string_view name) {
  name = name.substr(0, name.find_last_not_of("0123456789_") + 1);
  std::string lower;
  for (const char c : name) lower += c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
  const std::size_t at = lower.find_last_of("-_");
  if (at == std::string::npos) return false;
  constexpr std::array<std::string_view, 11> kHints{"col",     "colonly", "convcol", "convcolonly",
                                                    "noimp",   "occ",     "occonly", "navmesh",
                                                    "vehicle", "wheel",   "rigid"};
  return std::find(kHints.begin(), kHints.end(), std::string_view(lower).substr(at + 1)) != kHints.end();
}

}  // namespace

std::string kept_name(std::string_view name, std::size_t room) {
  std::string result;
  while (!name.empty()) {
    const std::string_view character = name.substr(0, first_character(name));
    const bool keep = !character.empty() && is_kept(code_point(character));
    const std::string_view written = keep ? character : "_";
    if (result.size() + written.size() > room) break;
    result += written;
    name.remove_prefix(std::max<std::size_t>(character.size(), 1));
  }
  return result.empty() ? "mesh" : result;
}

std::string visible_name(std::string_view name) {
  std::string result;
  for (const std::string_view prefix : {"UCX_", "UBX_", "USP_", "UCP_"})
    if (name.starts_with(prefix)) result = '_';
  result += name;
  return result;
}

std::vector<std::string> names_of_sources(const std::vector<std::string>& sources, std::size_t room,
                                          const Execution& execution) {
  Pacer pacer(execution);
  std::map<std::string_view, std::string> name_of;
  std::set<std::string> taken;
  std::map<std::string, std::size_t> last_number;  // highest number that each name was given
  std::vector<std::string> names;
  names.reserve(sources.size());
  for (const std::string& source : sources) {
    pacer.step(16);
    const auto [at, is_new] = name_of.try_emplace(source);
    if (is_new) {
      const std::string wanted = visible_name(source);
      const std::string piece = is_import_hint(kept_name(wanted, room)) ? "_piece" : "";
      std::string name = kept_name(wanted, room - piece.size()) + piece;
      if (!taken.insert(name).second) {
        for (std::size_t& number = last_number.try_emplace(name, 1).first->second;;) {
          const std::string end = piece + "_" + std::to_string(++number);
          name = kept_name(wanted, room - end.size()) + end;
          if (taken.insert(name).second) break;
        }
      }
      at->second = std::move(name);
    }
    names.push_back(at->second);
  }
  return names;
}

std::string padded(std::size_t number, std::size_t width) {
  std::string digits = std::to_string(number);
  if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
  return digits;
}

std::string fragment_name(std::string_view source, std::size_t number, std::size_t count) {
  return std::string(source) + "_" + padded(number, fragment_suffix(count) - 1);
}

std::size_t fragment_suffix(std::size_t count) {
  return 1 + std::to_string(std::max<std::size_t>(count, 1) - 1).size();
}

}  // namespace fracture
