// Controls for every parameter of GET /patterns. They are built from that table, so a server with new
// parameters gets new controls.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture::app {

/// A parameter as the server describes it, with the player's value.
struct ParameterControl {
  enum class Type { kInteger, kNumber, kChoice, kText };  ///< lists and vectors are text, as in a query
  std::string name, description, unit, hint;
  Type type = Type::kText;
  double low = 0, high = 1;
  std::vector<std::string> choices;
  bool set = false;  ///< sent only if true
  double number = 0;
  int choice = 0;
  std::string text;
};

class ParameterControls {
 public:
  /// Reads the answer of GET /patterns. Returns false if it is not such a table; the controls then stay
  /// unchanged.
  bool read(const std::string& patterns_json);
  bool empty() const { return general_.empty(); }

  /// Draws the controls inside a Dear ImGui window. Returns true if a value was changed.
  bool draw();
  /// The values that are set, as members of a request.
  nlohmann::json values() const;

  /// The general parameters, then those of the chosen pattern; for tests and draw().
  std::vector<ParameterControl*> shown();
  ParameterControl* find(const std::string& name);

 private:
  std::vector<ParameterControl> general_;
  std::map<std::string, std::vector<ParameterControl>> of_pattern_;
};

}  // namespace fracture::app
