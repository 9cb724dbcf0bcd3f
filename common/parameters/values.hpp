// One given parameter value, text or JSON, converted, checked and shown.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/parameters/spec.hpp"

namespace fracture {

/// "a, b or c".
std::string join(const std::vector<std::string>& words);
/// The value as a person typed it, short enough for an error message and free of control characters.
std::string shown(const nlohmann::json& value);
/// In as few digits as say the same number.
std::string shortest(double number);
/// Finite; text is converted, JSON must be a number.
std::optional<double> to_number(const nlohmann::json& value, bool is_text);

/// The legal values of a parameter, as the end of the sentence "'name' must be …".
std::string expectation(const ParameterSpec& spec);

/// Converts and checks. Text is converted, JSON must have the right type. kBadParameter, or kUnknownFormat of
/// `format`: `detail` is a sentence with the legal range and the offending value, `pointer` the JSON pointer to
/// the offender inside the value, empty for the whole.
Expected<ParameterValue> to_value(const ParameterSpec& spec, const RawParameter& raw);

/// The part of it for vectors, lists of them and matrices (vectors.cpp); spec.check is not asked.
Expected<ParameterValue> to_vectors(const ParameterSpec& spec, const RawParameter& raw);

}  // namespace fracture
