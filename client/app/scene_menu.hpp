// The scenes with their pictures, to choose from (Dear ImGui and OpenGL).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/render/gl_objects.hpp"

namespace fracture::app {

class SceneMenu {
 public:
  /// Reads the pictures, where they are found; a scene without one is a button with its name.
  SceneMenu();
  /// Draws the menu; `choose` gets the scene that was clicked. True when one was.
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
