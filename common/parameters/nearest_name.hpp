// "Did you mean": the known name that a misspelt name probably means.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fracture {

/// The first known name with the least edit distance (Damerau 1964). Nothing if more than a third of the letters would have to
/// change.
std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> known);

/// The `most` known names with the least edit distance, nearest first, equal ones in their given order. A long name is compared
/// by its beginning.
std::vector<std::string> nearest_names(std::string_view name, std::span<const std::string> known,
                                       std::size_t most);

}  // namespace fracture
