// Reads the table of parameters and the values, without Dear ImGui.
#include <algorithm>
#include <cmath>

#include "client/app/parameter_controls.hpp"

namespace fracture::app {
namespace {

using nlohmann::json;

std::string text_of(const json& entry, const char* key) {
  const auto it = entry.find(key);
  return it != entry.end() && it->is_string() ? it->get<std::string>() : std::string();
}

ParameterControl read_control(const json& entry) {
  ParameterControl control;
  control.name = text_of(entry, "name");
  control.description = text_of(entry, "description");
  control.unit = text_of(entry, "unit");
  control.hint = text_of(entry, "text");
  const std::string type = text_of(entry, "type");
  const json value = entry.value("default", json());
  if (const auto choices = entry.find("enum"); choices != entry.end() && choices->is_array()) {
    control.type = ParameterControl::Type::kChoice;
    for (const json& choice : *choices)
      if (choice.is_string()) control.choices.push_back(choice.get<std::string>());
    const auto at = std::find(control.choices.begin(), control.choices.end(),
                              value.is_string() ? value.get<std::string>() : "");
    if (at != control.choices.end()) control.choice = static_cast<int>(at - control.choices.begin());
    return control;
  }
  if (type == "integer" || type == "number") {
    control.type = type == "integer" ? ParameterControl::Type::kInteger : ParameterControl::Type::kNumber;
    control.low = entry.value("minimum", 0.0);
    control.high = entry.value("maximum", 1.0);
    control.number = value.is_number() ? value.get<double>() : control.low;
    return control;
  }
  if (value.is_string()) control.text = value.get<std::string>();
  return control;
}

std::vector<ParameterControl> read_list(const json& list) {
  std::vector<ParameterControl> controls;
  if (!list.is_array()) return controls;
  for (const json& entry : list)
    if (entry.is_object() && !text_of(entry, "name").empty()) controls.push_back(read_control(entry));
  return controls;
}

}  // namespace

bool ParameterControls::read(const std::string& patterns_json) {
  const json document = json::parse(patterns_json, nullptr, false);
  if (!document.is_object() || !document.contains("patterns") || !document.contains("parameters"))
    return false;
  std::vector<ParameterControl> general;
  for (ParameterControl& control : read_list(document["parameters"])) {
    // The game chooses the mesh and the fragment. It also needs physics, without which nothing falls.
    static const char* const kOurs[] = {"format", "fragment", "fragment_sites", "fragment_seed", "physics",
                                        "seed",   "intact",   "ue_collision",   "pivot"};
    if (std::none_of(std::begin(kOurs), std::end(kOurs),
                     [&](const char* name) { return control.name == name; }))
      general.push_back(std::move(control));
  }
  if (general.empty()) return false;
  general_ = std::move(general);
  of_pattern_.clear();
  for (const json& pattern : document["patterns"])
    if (pattern.is_object())
      of_pattern_[text_of(pattern, "name")] = read_list(pattern.value("parameters", json::array()));
  return true;
}

ParameterControl* ParameterControls::find(const std::string& name) {
  for (ParameterControl* control : shown())
    if (control->name == name) return control;
  return nullptr;
}

std::vector<ParameterControl*> ParameterControls::shown() {
  std::vector<ParameterControl*> list;
  std::string pattern;
  for (ParameterControl& control : general_) {
    list.push_back(&control);
    if (control.name == "pattern" && control.set && !control.choices.empty())
      pattern = control.choices[static_cast<std::size_t>(control.choice)];
  }
  if (const auto own = of_pattern_.find(pattern); own != of_pattern_.end())
    for (ParameterControl& control : own->second) list.push_back(&control);
  return list;
}

json ParameterControls::values() const {
  json values = json::object();
  for (const ParameterControl* control : const_cast<ParameterControls*>(this)->shown()) {
    if (!control->set) continue;
    switch (control->type) {
      case ParameterControl::Type::kInteger:
        values[control->name] = std::llround(std::clamp(control->number, control->low, control->high));
        break;
      case ParameterControl::Type::kNumber:
        values[control->name] = std::clamp(control->number, control->low, control->high);
        break;
      case ParameterControl::Type::kChoice:
        if (!control->choices.empty())
          values[control->name] = control->choices[static_cast<std::size_t>(control->choice)];
        break;
      case ParameterControl::Type::kText:
        if (!control->text.empty()) values[control->name] = control->text;
        break;
    }
  }
  return values;
}

}  // namespace fracture::app
