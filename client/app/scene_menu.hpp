// The scenes with their pictures, to choose from (Dear ImGui and OpenGL).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/render/gl_objects.hpp"

namespace fracture::app {

class SceneMenu {
 public:
  /// Reads the pictures that exist. A scene without one is shown as a button with its name.
  SceneMenu();
  /// Draws the menu. If a scene is clicked, passes its name to `choose` and returns true.
  bool draw(const std::function<void(const std::string&)>& choose) const;

 private:
  struct Entry {
    std::string scene;
    render::Texture picture;
    float aspect = 16.f / 9;
    bool shown = false;  ///< has a picture
  };
  std::vector<Entry> entries_;
};

}  // namespace fracture::app
