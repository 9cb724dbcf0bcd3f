// The names of other files in OBJ and MTL text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fracture {

/// The files that a statement `mtllib` names, from the text after this word. Names may contain blanks: one ends at the end of
/// the line or after a word that ends in ".mtl". Quotation marks around a name are removed.
std::vector<std::string> material_libraries(std::string_view rest);

/// The file of a texture statement (`map_Kd`, `norm`, …), from the text after this word.
struct MapFile {
  std::string_view name;  ///< may contain blanks; empty if the statement names no file
  /// The options -o, -s or -t state a placement of the texture other than the usual one.
  bool placed = false;
};
/// Skips the options before the name, each with the number of values that MTL defines for it. Numbers of which the last ones
/// may be missing (-o, -s, -t) are recognized as numbers.
MapFile file_of_map(std::string_view rest);

/// Whether a keyword of MTL is followed by a texture's file.
bool is_map(std::string_view keyword);

}  // namespace fracture
