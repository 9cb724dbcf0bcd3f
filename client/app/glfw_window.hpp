// An operating system window with an OpenGL 3.3 core context, and Dear ImGui drawn over it.
#pragma once

#include <epoxy/gl.h>
// GLFW must follow epoxy, which declares the OpenGL functions.
#include <GLFW/glfw3.h>

#include <memory>

#include "common/base/error.hpp"

namespace fracture::app {

/// Owns the window, its context and Dear ImGui, and ends all three together. Only one at a time, on the main
/// thread.
class GlfwWindow {
 public:
  /// Opens a window of this size in pixels. Returns kNoGraphics if the machine has no display, or if the system
  /// refuses an OpenGL context. The error contains the system's reason.
  static Expected<std::unique_ptr<GlfwWindow>> open(int width, int height);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  /// Call this after setting the game's callbacks: Dear ImGui installs its own in front of them and calls
  /// them.
  void start_overlay();
  GLFWwindow* get() const { return window_; }

 private:
  explicit GlfwWindow(GLFWwindow* window);
  GLFWwindow* window_;
  bool overlay_ = false;
};

}  // namespace fracture::app
