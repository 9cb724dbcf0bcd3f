// "Did you mean": the known name that a misspelt one was probably meant to be.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fracture {

/// The first of the least edit distance (Damerau 1964); nothing where more than a third of the letters
/// would have to change.
std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> known);

/// The `most` known names of the least edit distance from the name (of a long one, from its beginning),
/// nearest first; of equal ones in their own order.
std::vector<std::string> nearest_names(std::string_view name, std::span<const std::string> known,
                                       std::size_t most);

}  // namespace fracture
