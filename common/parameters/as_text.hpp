// A parameter's value in the form used in a query or a flag.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace fracture {

/// The text of a JSON value from a canonical form: lists as "a,b,c", lists of vectors as "x,y,z;x,y,z", and numbers so that they
/// read back exactly. Empty for a list of names if a name contains a comma or has a blank at either end, because the text would
/// then mean other names.
std::optional<std::string> as_text(const nlohmann::json& value);

}  // namespace fracture
