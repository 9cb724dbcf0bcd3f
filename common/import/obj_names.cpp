#include "common/import/obj_names.hpp"

#include "common/import/text_words.hpp"

namespace fracture {
namespace {

std::string small_letters(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::string_view unquoted(std::string_view name) {
  const bool marks = name.size() >= 2 && name.front() == '"' && name.back() == '"';
  return marks ? name.substr(1, name.size() - 2) : name;
}

/// Number of values after an option of a texture; -1: up to three numbers.
int values_of(std::string_view option) {
  if (option == "-o" || option == "-s" || option == "-t") return -1;
  if (option == "-mm") return 2;
  for (const char* one : {"-bm", "-boost", "-texres", "-clamp", "-blendu", "-blendv", "-cc", "-imfchan",
                          "-type", "-colorspace"})
    if (option == one) return 1;
  return 0;
}

}  // namespace

std::vector<std::string> material_libraries(std::string_view rest) {
  std::vector<std::string> names;
  std::string_view left = without_blanks(rest), tail = left;
  while (!tail.empty()) {
    const std::string_view word = take_word(tail);
    const std::string ending = small_letters(word.substr(word.size() < 5 ? 0 : word.size() - 5));
    const bool ends = ending.ends_with(".mtl") || ending.ends_with(".mtl\"");
    if (!ends && !without_blanks(tail).empty()) continue;
    names.emplace_back(unquoted(without_blanks(left.substr(0, left.size() - tail.size()))));
    left = tail = without_blanks(tail);
  }
  return names;
}

MapFile file_of_map(std::string_view rest) {
  MapFile file;
  for (rest = without_blanks(rest); rest.starts_with('-'); rest = without_blanks(rest)) {
    const std::string option = small_letters(take_word(rest));
    const int values = values_of(option);
    for (int k = 0; k < values; ++k) take_word(rest);
    for (int k = 0; k < 3 && values < 0; ++k) {
      std::string_view after = rest;
      const auto number = number_of(take_word(after));
      // The last word is the name, even if it looks like a number.
      if (!number || without_blanks(after).empty()) break;
      file.placed = file.placed || *number != (option == "-s" ? 1 : 0);
      rest = after;
    }
  }
  file.name = unquoted(without_blanks(rest));
  return file;
}

bool is_map(std::string_view keyword) {
  const std::string word = small_letters(keyword);
  if (word.starts_with("map_")) return true;
  for (const char* other : {"bump", "norm", "disp", "decal", "refl"})
    if (word == other) return true;
  return false;
}

}  // namespace fracture
