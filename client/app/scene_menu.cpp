#include "client/app/scene_menu.hpp"

#include <imgui.h>

#include <fstream>
#include <iterator>

#include "client/render/image.hpp"
#include "client/scenes/scene.hpp"

namespace fracture::app {

SceneMenu::SceneMenu() {
  for (const std::string& scene : scenes::scene_names()) {
    Entry& entry = entries_.emplace_back();
    entry.scene = scene;
    std::ifstream in(FRACTURE_SCENE_PICTURES "/" + scene + ".png", std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    const auto picture =
        render::decode_picture(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
    if (!picture) continue;
    entry.picture = render::make_texture();
    entry.aspect = static_cast<float>(picture->width) / static_cast<float>(picture->height);
    entry.shown = true;
    glBindTexture(GL_TEXTURE_2D, entry.picture.get());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, picture->width, picture->height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 picture->pixels.data());
    glBindTexture(GL_TEXTURE_2D, 0);
  }
}

bool SceneMenu::draw(const std::function<void(const std::string&)>& choose) const {
  constexpr float kWidth = 220;  // pixels
  constexpr int kColumns = 3;
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos(ImVec2(io.DisplaySize.x / 2, io.DisplaySize.y / 2), ImGuiCond_Always,
                          ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowBgAlpha(0.85f);
  ImGui::Begin("scenes", nullptr,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_AlwaysAutoResize);
  bool chosen = false;
  for (std::size_t k = 0; k < entries_.size(); ++k) {
    const Entry& entry = entries_[k];
    if (k % kColumns != 0) ImGui::SameLine();
    ImGui::BeginGroup();
    ImGui::PushID(entry.scene.c_str());
    bool clicked = false;
    if (entry.shown)
      clicked =
          ImGui::ImageButton(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(entry.picture.get())),
                             ImVec2(kWidth, kWidth / entry.aspect), ImVec2(0, 0), ImVec2(1, 1), 2);
    clicked = ImGui::Button(entry.scene.c_str(), ImVec2(kWidth + 4, 0)) || clicked;
    ImGui::PopID();
    ImGui::EndGroup();
    if (!clicked) continue;
    choose(entry.scene);
    chosen = true;
  }
  ImGui::End();
  return chosen;
}

}  // namespace fracture::app
