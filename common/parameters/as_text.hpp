// A parameter's value as a query or a flag says it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace fracture {

/// Of a value of a canonical form, which is JSON: lists as "a,b,c", lists of vectors as "x,y,z;x,y,z",
/// numbers so that they read back as themselves. Nothing for a list of names one of which has a comma or
/// stands between blanks, since text would say other names.
std::optional<std::string> as_text(const nlohmann::json& value);

}  // namespace fracture
