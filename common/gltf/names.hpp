// Names that every tool keeps as they are. They are in UTF-8 and have at most 63 bytes, because Blender and Unreal cut longer names.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/execution.hpp"

namespace fracture {

inline constexpr std::size_t kMaxName = 63;  ///< bytes

/// Returns the name with _ for each character that some tool would remove or replace: ASCII characters other than letters,
/// digits, _ and - (three.js removes [ ] . : /; Godot and Unreal replace more), white space, control characters, and bytes
/// that are not UTF-8. All other characters are kept. The name is cut to `room` bytes at the end of a character. Returns "mesh"
/// for an empty name.
std::string kept_name(std::string_view name, std::size_t room = kMaxName);

/// Returns the name, with _ before it if Unreal would take a mesh of this name for collision geometry (UCX_, UBX_, USP_, UCP_).
std::string visible_name(std::string_view name);

/// Returns a name for each name of a source's node, of at most `room` bytes. Equal names remain equal, and different names
/// remain different: if kept_name() is taken, _2, _3, … is appended. Fragments of a "Crate-col" or a "Car_Wheel" are called
/// "Crate-col_piece_07": without that word, Godot would add a collider to each of them, or turn it into a wheel. Throws
/// Interrupted.
std::vector<std::string> names_of_sources(const std::vector<std::string>& sources, std::size_t room,
                                          const Execution& execution);

/// Returns the number with at least `width` digits.
std::string padded(std::size_t number, std::size_t width);

/// Returns "<source>_007": all `count` fragments have the same number of digits. So fragments of any sources have different
/// names.
std::string fragment_name(std::string_view source, std::size_t number, std::size_t count);

/// Length of the suffix that fragment_name() appends, bytes.
std::size_t fragment_suffix(std::size_t count);

}  // namespace fracture
