// Token files with several names, for tests. The token of a name is the name followed by "-token-0123456789".
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/digest/digest.hpp"

namespace fracture::test {

inline std::string token_of(const std::string& name) { return name + "-token-0123456789"; }
/// The header field for a request by this name.
inline std::string by(const std::string& name) { return "Authorization: Bearer " + token_of(name) + "\r\n"; }

/// A single name; `more` contains further members.
inline nlohmann::json tenant(const std::string& name,
                             const std::vector<std::string>& scopes = {"read", "fracture", "bake"},
                             const nlohmann::json& more = nlohmann::json::object()) {
  nlohmann::json members = {{"name", name},
                            {"tokens", {{{"sha256", sha256(std::string_view(token_of(name))).hex()}}}},
                            {"scopes", scopes}};
  members.update(more);
  return members;
}

inline std::string tenant_file(const std::vector<nlohmann::json>& tenants) {
  return nlohmann::json{{"tenants", tenants}}.dump();
}

}  // namespace fracture::test
