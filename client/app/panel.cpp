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
    ImGui::Text("latency p50 %.1f ms, p99 %.1f ms (%zu fracture%s)", s.p50_ms, s.p99_ms, s.fractures_timed,
                s.fractures_timed == 1 ? "" : "s");
  else
    ImGui::TextDisabled("no latency yet");
  double all = 0;
  for (const protocol::StageTime& stage : s.last_stages) all = std::max(all, stage.milliseconds);
  for (const protocol::StageTime& stage : s.last_stages) {
    char text[48];
    std::snprintf(text, sizeof text, "%s %.2f ms", stage.name.c_str(), stage.milliseconds);
    ImGui::ProgressBar(all > 0 ? static_cast<float>(stage.milliseconds / all) : 0, ImVec2(-1, 0), text);
  }
  if (!s.last_trouble.empty()) ImGui::TextWrapped("last error: %s", s.last_trouble.c_str());
}

void frame_section(const PanelState& state) {
  std::array<float, 240> ordered;
  float worst = 0;
  for (std::size_t k = 0; k < ordered.size(); ++k) {
    ordered[k] = state.frame_ms[(state.next_frame + k) % ordered.size()];
    worst = std::max(worst, ordered[k]);
  }
  char text[64];
  std::snprintf(text, sizeof text, "worst frame %.2f ms, %.0f frames/s", static_cast<double>(worst),
                state.frames_per_second);
  ImGui::PlotLines("##frames", ordered.data(), static_cast<int>(ordered.size()), 0, text, 0,
                   std::max(4.f, worst), ImVec2(ImGui::GetContentRegionAvail().x, 60));
  ImGui::Text("%zu draw calls, submitted in %.2f ms", state.figures.draw_calls, state.figures.submit_ms);
}

void bodies_section(const Snapshot& now) {
  const world::Census& c = now.census;
  const game::GameFigures& f = now.figures;
  ImGui::Text("%zu bodies, %zu moving, %zu whole", c.bodies, c.moving, c.whole);
  ImGui::Text("%zu fragments in %zu groups, %zu bonds", c.fragments, c.groups, c.bonds);
  ImGui::Text("%" PRIu64 " requests, %" PRIu64 " swaps, %" PRIu64 " secondary, %zu faded", f.requests,
              f.swaps, f.secondary, c.faded);
  ImGui::Text("energy %.0f of %.0f J", now.ledger.energy, now.ledger.brought);
  ImGui::Text("a step took %.2f ms", now.step_ms);
  if (!f.last_break.empty()) ImGui::TextWrapped("%s", f.last_break.c_str());
  if (!f.last_trouble.empty()) ImGui::TextWrapped("%s", f.last_trouble.c_str());
}

}  // namespace

void draw_panel(PanelState& state, const scenes::Scene& shown, const Snapshot& now,
                const protocol::Client& client, const PanelActions& actions) {
  if (!state.panel) return;
  ImGui::SetNextWindowPos(ImVec2(12, 12), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize(ImVec2(340, 620), ImGuiCond_FirstUseEver);
  ImGui::Begin("fracture", &state.panel);
  ImGui::TextWrapped("%s", shown.title.c_str());
  for (const std::string& scene : scenes::scene_names()) {
    if (ImGui::SmallButton(scene.c_str())) actions.load_scene(scene);
    ImGui::SameLine();
  }
  if (ImGui::SmallButton("reset")) actions.reset();
  if (state.loading) ImGui::TextUnformatted("loading …");
  if (!state.note.empty()) ImGui::TextWrapped("%s", state.note.c_str());
  if (ImGui::CollapsingHeader("server", ImGuiTreeNodeFlags_DefaultOpen)) server_section(client);
  if (ImGui::CollapsingHeader("frame", ImGuiTreeNodeFlags_DefaultOpen)) frame_section(state);
  if (ImGui::CollapsingHeader("bodies", ImGuiTreeNodeFlags_DefaultOpen)) bodies_section(now);
  if (ImGui::CollapsingHeader("view")) {
    int debug = static_cast<int>(state.view.debug);
    if (ImGui::Combo("show", &debug, view::kDebugViewNames.data(),
                     static_cast<int>(view::kDebugViewNames.size())))
      state.view.debug = static_cast<view::DebugView>(debug);
    int picture = static_cast<int>(state.picture);
    if (ImGui::Combo("picture", &picture, render::kTierWishNames.data(),
                     static_cast<int>(render::kTierWishNames.size())))
      state.picture = static_cast<render::TierWish>(picture);
    if (state.picture == render::TierWish::kAuto)
      ImGui::TextDisabled("picture: %s now",
                          render::kTierWishNames[static_cast<std::size_t>(state.figures.tier)]);
    ImGui::SliderInt("sky shadows", &state.view.sky_shadows, 0, 32);
    ImGui::Checkbox("sun shadow", &state.view.sun_shadow);
    ImGui::Checkbox("dust and crumbs", &state.effects);
  }
  if (state.sound && ImGui::CollapsingHeader("sound")) {
    if (state.silent)
      ImGui::TextDisabled("no sound device");
    else
      ImGui::SliderFloat("volume", &state.volume, 0, 1);
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
      actions.set_overrides();
  }
  if (now.last_glb && ImGui::Button("save last answer as GLB")) actions.save_glb();
  ImGui::End();
}

}  // namespace fracture::app
