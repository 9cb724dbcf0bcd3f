#include "client/app/hud.hpp"

#include <imgui.h>

#include <string>

namespace fracture::app {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing;
constexpr float kEdge = 12;  // pixels

ImVec4 color_of(protocol::ServerState state) {
  switch (state) {
    case protocol::ServerState::kReachable:
      return {0.35f, 0.85f, 0.4f, 1};
    case protocol::ServerState::kOverloaded:
      return {0.95f, 0.75f, 0.2f, 1};
    default:
      return {0.95f, 0.35f, 0.3f, 1};
  }
}

const char* words_for(protocol::ServerState state) {
  switch (state) {
    case protocol::ServerState::kReachable:
      return "server answers";
    case protocol::ServerState::kOverloaded:
      return "server is busy, retrying";
    case protocol::ServerState::kAbsent:
      return "no server: nothing breaks";
    default:
      return "connecting to the server";
  }
}

}  // namespace

void draw_hud(const PanelState& state, const Snapshot& now, const protocol::Client& client) {
  if (state.panel) return;  // the panel shows all of this and more
  ImGui::SetNextWindowPos(ImVec2(kEdge, kEdge), ImGuiCond_Always);
  ImGui::SetNextWindowBgAlpha(0.45f);
  ImGui::Begin("hud", nullptr, kPlain);
  const protocol::Status status = client.status();
  ImGui::TextColored(color_of(status.state), "%s", words_for(status.state));
  if (status.fractures_timed > 0) {
    ImGui::SameLine();
    ImGui::Text("in %.0f ms", status.p50_ms);
  }
  const game::GameFigures& figures = now.figures;
  if (!figures.last_break.empty()) ImGui::TextUnformatted(figures.last_break.c_str());
  const world::Census& census = now.census;
  ImGui::Text("%zu whole, %zu pieces, %zu moving", census.whole, census.fragments, census.moving);
  if (state.loading) ImGui::TextUnformatted("loading ...");
  ImGui::End();
}

void draw_help(const PanelState& state) {
  if (!state.help) return;
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x - kEdge, kEdge), ImGuiCond_Always, ImVec2(1, 0));
  ImGui::SetNextWindowBgAlpha(0.6f);
  ImGui::Begin("help", nullptr, kPlain);
  ImGui::TextUnformatted(
      "WASD, Q E      move (Shift: faster)\n"
      "right button   hold: look around; Tab: always\n"
      "click          use the tool at the pointer\n"
      "F              switch tool: ball, wrecking ball, explosion\n"
      "X              hold: gravity on\n"
      "G              gravity always on\n"
      "T              slow motion; . (dot): single step\n"
      "B              hold: rewind; release: continue there\n"
      "F5             save the game\n"
      "1 - 8          material\n"
      "M              scene menu; N: next scene\n"
      "R              reset\n"
      "V              debug view\n"
      "P              screenshot\n"
      "U              unit of your meshes\n"
      "F1             panel\n"
      "H              this help\n"
      "Esc            quit\n"
      "drop files     break your own meshes");
  ImGui::End();
}

void draw_hint(const PanelState& state, const glm::vec2& aim) {
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x / 2, io.DisplaySize.y - 16), ImGuiCond_Always,
                          ImVec2(0.5f, 1));
  ImGui::SetNextWindowBgAlpha(0.4f);
  ImGui::Begin("hint", nullptr, kPlain);
  if (!state.note.empty()) ImGui::TextUnformatted(state.note.c_str());
  const std::string click =
      std::string("click ") + kToolActions[static_cast<std::size_t>(state.tool)] + " - F: switch tool - ";
  const std::string hint =
      state.gravity_always ? click + "G pauses - H for help"
      : state.gravity_held
          ? std::string("gravity is on")
          : "paused - hold X for gravity, press G to keep gravity on - " + click + "H for help";
  ImGui::TextUnformatted(hint.c_str());
  ImGui::End();
  ImDrawList* list = ImGui::GetForegroundDrawList();
  const ImVec2 at(aim.x, aim.y);
  list->AddCircle(at, 6, IM_COL32(0, 0, 0, 120), 20, 3);
  list->AddCircle(at, 6, IM_COL32(255, 255, 255, 200), 20, 1.5f);
  list->AddCircleFilled(at, 1.5f, IM_COL32(255, 255, 255, 200));
}

void draw_fragment_ids(const game::Moment& moment, const render::Camera& camera, int width, int height) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const glm::mat4 matrix = camera.view_projection();
  for (const game::Moment::Part& part : moment.parts) {
    if (!part.broken) continue;
    const world::FragmentSet& set = world::fragments_of(*part.broken->fragments);
    const std::vector<world::FragmentState>& states = part.fragments;
    for (std::size_t k = 0; k < states.size(); ++k) {
      if (!states[k].present) continue;
      const glm::vec4 clip =
          matrix * glm::vec4(glm::vec3(states[k].asset_to_world.point(set.fragments[k].mass.center)), 1);
      if (clip.w <= 0) continue;
      const ImVec2 at((0.5f + 0.5f * clip.x / clip.w) * static_cast<float>(width),
                      (0.5f - 0.5f * clip.y / clip.w) * static_cast<float>(height));
      list->AddText(at, IM_COL32(255, 255, 255, 220), std::to_string(k).c_str());
    }
  }
}

}  // namespace fracture::app
