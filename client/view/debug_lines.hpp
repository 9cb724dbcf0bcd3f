// Coloured lines over a picture: hulls and bonds.
#pragma once

#include <vector>

#include "client/render/camera.hpp"
#include "client/render/gl_objects.hpp"

namespace fracture::view {

class DebugLines {
 public:
  static Expected<DebugLines> create();
  void add(const glm::vec3& a, const glm::vec3& b, const glm::vec3& color) {
    vertices_.push_back({a, color});
    vertices_.push_back({b, color});
  }
  /// Draws the added lines into the bound framebuffer, and forgets them.
  void draw(const render::Camera& camera, bool through);

 private:
  struct Point {
    glm::vec3 position, color;
  };
  DebugLines() = default;
  render::Program program_;
  render::VertexArray array_;
  render::Buffer buffer_;
  std::vector<Point> vertices_;
};

}  // namespace fracture::view
