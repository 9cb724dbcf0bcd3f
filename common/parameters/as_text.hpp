// The value of a parameter as a query or a flag contains it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace fracture {

/// The text of a JSON value of a canonical form: lists as "a,b,c", lists of vectors as "x,y,z;x,y,z", numbers so that they read
/// back exactly. Nothing for a list of names of which one contains a comma or begins or ends with a blank, because the text would
/// mean other names.
std::optional<std::string> as_text(const nlohmann::json& value);

}  // namespace fracture
