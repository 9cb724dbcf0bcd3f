// The camera of the window's game: keys move the eye, and the mouse turns the view or points.
#pragma once

#include <glm/glm.hpp>

#include "client/app/glfw_window.hpp"
#include "client/scenes/scene.hpp"

namespace fracture::app {

class FlyCamera {
 public:
  /// `window` must outlive the camera.
  explicit FlyCamera(GLFWwindow* window) : window_(window) {}

  /// Moves the camera to the scene's view.
  void aim(const scenes::Scene& scene);
  /// Moves the camera to the scene's view at the given time of the game, in seconds. Does nothing once the
  /// player has moved or turned the view.
  void follow(const scenes::Scene& scene, double seconds);
  /// Moves for one frame: W A S D, Q E, Shift, and the mouse if it turns the view.
  void move(float seconds);
  /// Sets whether the mouse turns the view; the pointer is then hidden.
  void look(bool on);
  bool looks() const { return captured_; }

  const glm::vec3& eye() const { return eye_; }
  glm::vec3 forward() const;  ///< unit length
  /// In pixels of the window: the pointer, or the centre if the mouse turns the view.
  glm::vec2 aim_point() const;
  /// Direction from the eye to the point under aim_point(), of unit length.
  glm::dvec3 aim_direction() const;

 private:
  void look_from(const scenes::View& view);

  GLFWwindow* window_;
  glm::vec3 eye_{0, 2, 8};
  float yaw_ = 0, pitch_ = 0;
  bool captured_ = false, had_cursor_ = false, taken_ = false;
  double cursor_x_ = 0, cursor_y_ = 0;
};

}  // namespace fracture::app
