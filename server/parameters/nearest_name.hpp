// "Did you mean": the known name that a misspelt one was probably meant to be.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace fracture {

/// The first of the least edit distance (Damerau 1964); nothing where more than a third of the letters
/// would have to change.
std::optional<std::string> nearest_name(std::string_view name, std::span<const std::string> known);

}  // namespace fracture
