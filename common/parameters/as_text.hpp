// A parameter's value in the form used in a query or a flag.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace fracture {

/// Returns a canonical form's JSON value as text: lists as "a,b,c", lists of vectors as "x,y,z;x,y,z", the
/// entries of `assign` as "selector:material;selector:material" or JSON, and numbers that read back exactly. Empty for a list of names if a name contains a comma or begins or ends
/// with a blank, because the text would then mean other names.
std::optional<std::string> as_text(const nlohmann::json& value);

}  // namespace fracture
