#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace fracture {

/// As everything else that an answer says: the shortest that reads back as the same double.
inline std::string text_of(double value) { return nlohmann::json(value).dump(); }

}  // namespace fracture
