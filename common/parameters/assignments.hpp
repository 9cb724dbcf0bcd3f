// The parameter `assign`: materials for single parts of a mesh.
//
//   text  Wall_*:brick;slot=Glass:glass;part=3:wood        selector:material; without node=, slot= or part= it is a node
//   JSON  [{"node": "Wall_*", "material": "brick"},
//          {"slot": ["Glass", "Pane*"], "material": "glass", "rough_amplitude": 0.01}, {"part": 3, "material": "wood"}]
//
// Text that begins with '[' is JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/parameters/parameters.hpp"
#include "common/parameters/spec.hpp"

namespace fracture {

/// Limits of an entry's selector.
inline constexpr std::size_t kMostNamesOfSelector = 100, kMostBytesOfName = 1000;

/// The row of `assign`. It comes last in the table.
ParameterSpec assign_row();

/// Reads the value of `assign`, without checking the parameters in it. Error: kBadParameter, with the place in `pointer`.
Expected<std::vector<RawAssignment>> to_assignments(const RawParameter& raw);

/// Whether an entry may contain this parameter: a material sets it, or it belongs to a pattern.
bool is_assignable(std::string_view name);

/// Whether a parameter of the request also applies to parts with a material of their own.
bool is_inherited(std::string_view name);

/// Returns the selector as members of an entry: `node`, `slot`, `part`.
nlohmann::json to_json(const PartSelector& selector);

/// Returns the walls of all parts in the form of `assign`. Null if no entry changes them.
nlohmann::json walls_as_assignments(const HollowOptions& hollow);

/// Returns `assign` in the form for a query or a flag: as selector:material if that is possible, otherwise as JSON.
std::string assignments_as_text(const nlohmann::json& entries);

}  // namespace fracture
