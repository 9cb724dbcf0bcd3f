// From where the window's game is seen: keys move the eye, the mouse turns it or points.
#pragma once

#include <glm/glm.hpp>

#include "client/app/glfw_window.hpp"
#include "client/scenes/scene.hpp"

namespace fracture::app {

class FlyCamera {
 public:
  /// `window` outlives the camera.
  explicit FlyCamera(GLFWwindow* window) : window_(window) {}

  /// As the scene has it.
  void aim(const scenes::Scene& scene);
  /// The same as it is at that time of the game, in seconds; not once the player has moved or turned the view.
  void follow(const scenes::Scene& scene, double seconds);
  /// A frame: W A S D, Q E, Shift, and the mouse while it looks.
  void move(float seconds);
  /// The mouse turns the view and has no pointer.
  void look(bool on);
  bool looks() const { return captured_; }

  const glm::vec3& eye() const { return eye_; }
  glm::vec3 forward() const;  ///< unit length
  /// In pixels of the window: the pointer, or the middle where there is none.
  glm::vec2 aim_point() const;
  /// From the eye to what lies under aim_point(), unit length.
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
