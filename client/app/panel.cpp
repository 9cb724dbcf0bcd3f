#include "client/app/panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>

namespace fracture::app {
namespace {

void server_section(const protocol::Client& client) {
  const protocol::Status s = client.status();
  const ImVec4 color = s.state == protocol::ServerState::kReachable    ? ImVec4(0.35f, 0.85f, 0.4f, 1)
                       : s.state == protocol::ServerState::kOverloaded ? ImVec4(0.95f, 0.75f, 0.2f, 1)
                                                                       : ImVec4(0.95f, 0.35f, 0.3f, 1);
  ImGui::TextColored(color, "%s", name(s.state));
  ImGui::SameLine();
  ImGui::Text("  %zu open, %" PRIu64 " answered, %" PRIu64 " failed, %" PRIu64 " retried", s.open, s.answered,
              s.failed, s.retried);
  if (s.fractures_timed > 0)
    ImGui::Text("latency p50 %.1f ms, p99 %.1f ms (%zu)", s.p50_ms, s.p99_ms, s.fractures_timed);
  else
    ImGui::TextDisabled("no latency yet");
  double all = 0;
  for (const protocol::StageTime& stage : s.last_stages) all = std::max(all, stage.milliseconds);
  for (const protocol::StageTime& stage : s.last_stages) {
    char text[48];
    std::snprintf(text, sizeof text, "%s %.2f ms", stage.name.c_str(), stage.milliseconds);
    ImGui::ProgressBar(all > 0 ? static_cast<float>(stage.milliseconds / all) : 0, ImVec2(-1, 0), text);
  }
  if (!s.last_trouble.empty()) ImGui::TextWrapped("last trouble: %s", s.last_trouble.c_str());
}

void frame_section(const PanelState& state) {
  std::array<float, 240> ordered;
  float worst = 0;
  for (std::size_t k = 0; k < ordered.size(); ++k) {
    ordered[k] = state.frame_ms[(state.next_frame + k) % ordered.size()];
    worst = std::max(worst, ordered[k]);
  }
  char text[64];
  std::snprintf(text, sizeof text, "worst %.2f ms, %.0f frames/s", static_cast<double>(worst),
                state.frames_per_second);
  ImGui::PlotLines("##frames", ordered.data(), static_cast<int>(ordered.size()), 0, text, 0,
                   std::max(4.f, worst), ImVec2(-1, 60));
  ImGui::Text("%zu draw calls, submitted in %.2f ms", state.figures.draw_calls, state.figures.submit_ms);
}

void bodies_section(const game::Game& game) {
  const world::Census c = game.world().census();
  const game::GameFigures& f = game.figures();
  ImGui::Text("%zu bodies, %zu moving, %zu whole", c.bodies, c.moving, c.whole);
  ImGui::Text("%zu fragments in %zu groups, %zu bonds", c.fragments, c.groups, c.bonds);
  ImGui::Text("%" PRIu64 " requests, %" PRIu64 " swaps, %" PRIu64 " secondary, %zu faded", f.requests,
              f.swaps, f.secondary, c.faded);
  if (!f.last_trouble.empty()) ImGui::TextWrapped("%s", f.last_trouble.c_str());
}

}  // namespace

void draw_panel(PanelState& state, game::Game& game, const protocol::Client& client,
                const PanelActions& actions) {
  if (!state.panel) return;
  ImGui::SetNextWindowPos(ImVec2(12, 12), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize(ImVec2(340, 620), ImGuiCond_FirstUseEver);
  ImGui::Begin("fracture", &state.panel);
  ImGui::TextWrapped("%s", game.scene().title.c_str());
  for (const std::string& scene : scenes::scene_names()) {
    if (ImGui::SmallButton(scene.c_str())) actions.load_scene(scene);
    ImGui::SameLine();
  }
  if (ImGui::SmallButton("reset")) actions.reset();
  if (state.loading) ImGui::TextUnformatted("loading …");
  if (!state.note.empty()) ImGui::TextWrapped("%s", state.note.c_str());
  if (ImGui::CollapsingHeader("server", ImGuiTreeNodeFlags_DefaultOpen)) server_section(client);
  if (ImGui::CollapsingHeader("frame", ImGuiTreeNodeFlags_DefaultOpen)) frame_section(state);
  if (ImGui::CollapsingHeader("bodies", ImGuiTreeNodeFlags_DefaultOpen)) bodies_section(game);
  if (ImGui::CollapsingHeader("view")) {
    int debug = static_cast<int>(state.view.debug);
    if (ImGui::Combo("show", &debug, view::kDebugViewNames.data(),
                     static_cast<int>(view::kDebugViewNames.size())))
      state.view.debug = static_cast<view::DebugView>(debug);
    ImGui::SliderInt("sky shadows", &state.view.sky_shadows, 0, 32);
    ImGui::Checkbox("sun shadow", &state.view.sun_shadow);
  }
  if (ImGui::CollapsingHeader("next fracture")) {
    for (const std::string& material : scenes::material_names()) {
      if (ImGui::SmallButton(material.c_str())) actions.set_material(material);
      if (&material != &scenes::material_names()[3]) ImGui::SameLine();
    }
    ImGui::NewLine();
    if (state.parameters.empty())
      ImGui::TextDisabled("waiting for GET /patterns");
    else if (state.parameters.draw())
      game.settings().overrides = state.parameters.values();
  }
  if (game.last_glb() && ImGui::Button("save last answer as GLB")) actions.save_glb();
  ImGui::End();
}

void draw_help(const PanelState& state) {
  const ImGuiIO& io = ImGui::GetIO();
  constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                      ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing;
  if (state.help) {
    ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x - 12, 12), ImGuiCond_Always, ImVec2(1, 0));
    ImGui::SetNextWindowBgAlpha(0.6f);
    ImGui::Begin("help", nullptr, kPlain);
    ImGui::TextUnformatted(
        "WASD, Q E   move (Shift: faster)\n"
        "mouse       look (Tab frees the pointer)\n"
        "X held      gravity runs\n"
        "G           gravity always on\n"
        "click       throw a ball\n"
        "1 - 8       material\n"
        "N           next scene\n"
        "V           debug view\n"
        "R           reset\n"
        "P           screenshot\n"
        "F1          panel\n"
        "H           this help\n"
        "Esc         leave\n"
        "drop files  break your own meshes");
    ImGui::End();
  }
  ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x / 2, io.DisplaySize.y - 16), ImGuiCond_Always,
                          ImVec2(0.5f, 1));
  ImGui::SetNextWindowBgAlpha(0.4f);
  ImGui::Begin("hint", nullptr, kPlain);
  ImGui::TextUnformatted(state.gravity_always ? "G pauses - click throws a ball"
                         : state.gravity_held ? "gravity runs"
                                              : "paused - hold X for gravity, G for always - H for help");
  ImGui::End();
  // Where a ball goes.
  ImDrawList* list = ImGui::GetForegroundDrawList();
  const ImVec2 middle(io.DisplaySize.x / 2, io.DisplaySize.y / 2);
  list->AddCircle(middle, 5, IM_COL32(255, 255, 255, 160), 16, 1.5f);
}

void draw_fragment_ids(const game::Game& game, const render::Camera& camera, int width, int height) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const glm::mat4 matrix = camera.view_projection();
  std::vector<world::FragmentState> states;
  for (const game::Thing& thing : game.things()) {
    if (!thing.fragments) continue;
    const world::FragmentSet& set = world::fragments_of(*thing.fragments->fragments);
    game.world().fragment_states(thing.id, states);
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
