// A repair or a reading of a mesh that is offered and not done, because it would change what the mesh is.
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace fracture {

/// One offer in a report. A request with these parameters, and the rest as it was, does what the text says.
struct Choice {
  struct Setting {
    std::string name;                         ///< of a parameter of a request
    std::variant<double, std::string> value;  ///< as in JSON
    bool operator==(const Setting&) const = default;
  };
  std::string kind;  ///< "unit", "room", "lid" or "crack"
  std::vector<Setting> parameters;
  std::string text;  ///< what was found, and what these parameters do about it
  bool operator==(const Choice&) const = default;
};

}  // namespace fracture
