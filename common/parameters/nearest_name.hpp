// "Did you mean": the known name for which a misspelt name was probably meant.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fracture {

/// The first known name with the smallest edit distance (Damerau 1964). Empty if more than a third of the letters would have to
/// change.
std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> known);

/// The `most` known names with the smallest edit distances, nearest first. Names with equal distances keep their order. Only the
/// beginning of a long name is compared.
std::vector<std::string> nearest_names(std::string_view name, std::span<const std::string> known,
                                       std::size_t most);

}  // namespace fracture
