// The subjects under which documents, the help and the page list parameters, and the other words by which people look for them.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/parameters/spec.hpp"

namespace fracture {

struct GroupedParameter {
  std::string_view name;
  /// Other words for the parameter, separated by ", ", in lower case. Empty: none.
  std::string_view synonyms;
};

struct ParameterGroup {
  std::string_view title;  ///< heading, such as "Rough cuts"
  std::string_view words;  ///< Markdown below the heading; empty: none
  std::span<const GroupedParameter> parameters;
};

/// Returns the groups in the order in which they are listed. Every parameter is in exactly one of them.
std::span<const ParameterGroup> parameter_groups();

/// Returns the JSON for `parameter_groups` in GET /limits: [{title, description, parameters: [names]}].
nlohmann::json parameter_groups_json();

/// Returns the other words for a parameter; empty if there are none.
std::vector<std::string> synonyms_of(std::string_view parameter);

/// Returns the parameter that a wrong name probably means: the first one with this synonym, otherwise the known name that is most
/// similar. Upper case, dashes, underscores and spaces do not matter in a synonym.
std::optional<std::string> parameter_meant_by(std::string_view name, std::span<const std::string> known);

/// Returns the choice that a wrong value of a choice parameter probably means: by a synonym such as "steel", otherwise the most
/// similar choice. Empty if no choice is similar.
std::optional<std::string> choice_meant_by(const ParameterSpec& spec, std::string_view value);

}  // namespace fracture
