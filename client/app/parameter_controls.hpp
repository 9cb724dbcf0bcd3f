// Controls for every parameter of GET /patterns, built from that table: a server with new parameters gets new
// controls.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fracture::app {

/// One parameter, as the server describes it, and what the player has set.
struct ParameterControl {
  enum class Type { kInteger, kNumber, kChoice, kText };  ///< lists and vectors are text, as in a query
  std::string name, description, unit, hint;
  Type type = Type::kText;
  double low = 0, high = 1;
  std::vector<std::string> choices;
  bool set = false;  ///< only then it is sent
  double number = 0;
  int choice = 0;
  std::string text;
};

class ParameterControls {
 public:
  /// Reads the answer of GET /patterns; false where it is not such a table (the controls stay as they are).
  bool read(const std::string& patterns_json);
  bool empty() const { return general_.empty(); }

  /// Draws them (inside a Dear ImGui window). True when something was changed.
  bool draw();
  /// What is set, as members for a request.
  nlohmann::json values() const;

  /// The general ones, then those of the chosen pattern; for tests and for draw().
  std::vector<ParameterControl*> shown();
  ParameterControl* find(const std::string& name);

 private:
  std::vector<ParameterControl> general_;
  std::map<std::string, std::vector<ParameterControl>> of_pattern_;
};

}  // namespace fracture::app
