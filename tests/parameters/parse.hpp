// Parameters in the form of a request, for the tests of the table.
#pragma once

#include <string>

#include "common/parameters/parameters.hpp"

namespace fracture {

inline const ParameterTable& table() {
  static const ParameterTable instance(100'000, FormatSet());
  return instance;
}

inline Expected<RequestParameters> parse_text(const std::string& name, const std::string& value) {
  return table().parse({{name, value, true}});
}

}  // namespace fracture
