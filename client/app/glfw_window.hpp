// A window of the system with an OpenGL 3.3 core context, and Dear ImGui over it.
#pragma once

#include <epoxy/gl.h>
// GLFW after epoxy, which brings OpenGL's names.
#include <GLFW/glfw3.h>

#include <memory>

#include "common/base/error.hpp"

namespace fracture::app {

/// Window, context and Dear ImGui, which end together. One at a time, on the main thread.
class GlfwWindow {
 public:
  /// Pixels. kNoGraphics where there is no display or no such context, with the system's reason.
  static Expected<std::unique_ptr<GlfwWindow>> open(int width, int height);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  /// After the callbacks of the game are set: Dear ImGui puts its own in front and calls them.
  void start_overlay();
  GLFWwindow* get() const { return window_; }

 private:
  explicit GlfwWindow(GLFWwindow* window);
  GLFWwindow* window_;
  bool overlay_ = false;
};

}  // namespace fracture::app
