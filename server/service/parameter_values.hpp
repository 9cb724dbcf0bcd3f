// One given parameter value, text or JSON, converted and shown: what the table of parameters is made of.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/service/parameters.hpp"

namespace fracture {

/// "a, b or c".
std::string join(const std::vector<std::string>& words);
/// The value as a person typed it, short enough for an error message and free of control characters.
std::string shown(const nlohmann::json& value);
/// In as few digits as say the same number.
std::string shortest(double number);

/// Nothing when the value is not of the kind asked for. Text is converted, JSON must have the right type.
std::optional<std::uint64_t> to_integer(const RawParameter& raw);
std::optional<double> to_number(const RawParameter& raw);  ///< finite
/// Sorted, each once; nothing when an entry is empty, no UTF-8, or no text.
std::optional<std::vector<std::string>> to_names(const RawParameter& raw);
/// 1 to 63 bytes of UTF-8 without control characters.
std::optional<std::string> to_text(const RawParameter& raw);

}  // namespace fracture
