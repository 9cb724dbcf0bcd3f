// Converts, checks and shows a single parameter value, given as text or JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/parameters/spec.hpp"

namespace fracture {

/// Joins names as "a, b or c".
std::string join(const std::vector<std::string>& words);
/// Returns the value as the user typed it, short enough for an error message and free of control
/// characters.
std::string shown(const nlohmann::json& value);
/// Returns the number in the fewest digits that read back to the same value.
std::string shortest(double number);
/// Reads a finite number. Text is converted; JSON must be a number.
std::optional<double> to_number(const nlohmann::json& value, bool is_text);

/// Returns the legal values of a parameter, as the end of the sentence "'name' must be …".
std::string expectation(const ParameterSpec& spec);

/// Converts and checks a value. Text is converted; JSON must have the right type. Errors: kBadParameter, or kUnknownFormat for
/// `format`. `detail` states the valid range and the wrong value. `pointer` is the JSON pointer to the wrong part of the value,
/// or empty for the whole value.
Expected<ParameterValue> to_value(const ParameterSpec& spec, const RawParameter& raw);

/// Returns a value as JSON, in the form that to_value() reads. Not for `assign`.
nlohmann::json to_json(const ParameterSpec& spec, const ParameterValue& value);

/// Does the same as to_value() for vectors, lists of vectors and matrices (vectors.cpp), without spec.check.
Expected<ParameterValue> to_vectors(const ParameterSpec& spec, const RawParameter& raw);

}  // namespace fracture
