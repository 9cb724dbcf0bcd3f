#include "client/app/parameter_controls.hpp"

#include <imgui.h>
#include <imgui_stdlib.h>

namespace fracture::app {

bool ParameterControls::draw() {
  bool changed = false;
  for (ParameterControl* control : shown()) {
    ImGui::PushID(control->name.c_str());
    changed |= ImGui::Checkbox("##set", &control->set);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(150);
    if (!control->set) ImGui::PushStyleVar(ImGuiStyleVar_Alpha, 0.5f);
    bool edited = false;
    switch (control->type) {
      case ParameterControl::Type::kInteger:
      case ParameterControl::Type::kNumber: {
        const bool whole = control->type == ParameterControl::Type::kInteger;
        const double range = control->high - control->low;
        // A slider if the range is small enough to hit each value, otherwise a text field.
        if (range <= 1000) {
          edited = ImGui::SliderScalar("##value", ImGuiDataType_Double, &control->number, &control->low,
                                       &control->high, whole ? "%.0f" : "%.3g");
        } else {
          edited = ImGui::InputDouble("##value", &control->number, 0, 0, whole ? "%.0f" : "%.6g");
        }
        break;
      }
      case ParameterControl::Type::kChoice: {
        const auto name = [](void* data, int k, const char** out) {
          *out = static_cast<ParameterControl*>(data)->choices[static_cast<std::size_t>(k)].c_str();
          return true;
        };
        edited = ImGui::Combo("##value", &control->choice, name, control,
                              static_cast<int>(control->choices.size()));
        break;
      }
      case ParameterControl::Type::kText:
        edited = ImGui::InputTextWithHint("##value", control->hint.c_str(), &control->text);
        break;
    }
    if (!control->set) ImGui::PopStyleVar();
    if (edited) control->set = changed = true;
    ImGui::SameLine();
    ImGui::TextUnformatted(
        (control->name + (control->unit.empty() ? "" : " (" + control->unit + ")")).c_str());
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", control->description.c_str());
    ImGui::PopID();
  }
  return changed;
}

}  // namespace fracture::app
