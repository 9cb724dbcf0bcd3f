// Finds the known name that a misspelt name was probably meant to be ("Did you mean ...").
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fracture {

/// Returns the first known name with the smallest edit distance (Damerau 1964). Empty if more than a third
/// of the letters would have to change.
std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> known);

/// Returns the `most` known names with the smallest edit distances, nearest first. Names with equal
/// distances keep their order. Only the beginning of a long name is compared.
std::vector<std::string> nearest_names(std::string_view name, std::span<const std::string> known,
                                       std::size_t most);

/// Returns " Did you mean 'lid' or 'lip'?" with at most three of the known names that are nearest. Empty if none is as near as
/// nearest_name() requires.
std::string did_you_mean(std::string_view name, std::span<const std::string> known);

}  // namespace fracture
