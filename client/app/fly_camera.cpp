#include "client/app/fly_camera.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "client/view/scene_view.hpp"

namespace fracture::app {

void FlyCamera::look(bool on) {
  if (captured_ == on) return;
  captured_ = on;
  had_cursor_ = false;
  glfwSetInputMode(window_, GLFW_CURSOR, on ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
}

glm::vec2 FlyCamera::aim_point() const {
  int width = 1, height = 1;
  glfwGetWindowSize(window_, &width, &height);
  if (captured_) return {0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height)};
  return {static_cast<float>(std::clamp(cursor_x_, 0.0, static_cast<double>(width))),
          static_cast<float>(std::clamp(cursor_y_, 0.0, static_cast<double>(height)))};
}

glm::dvec3 FlyCamera::aim_direction() const {
  int width = 1, height = 1;
  glfwGetWindowSize(window_, &width, &height);
  const glm::vec2 at = aim_point() / glm::vec2(std::max(width, 1), std::max(height, 1));
  const render::Camera camera = view::look_at(
      eye_, eye_ + forward(), static_cast<float>(width) / static_cast<float>(std::max(height, 1)));
  const glm::vec4 far =
      glm::inverse(camera.view_projection()) * glm::vec4(2 * at.x - 1, 1 - 2 * at.y, 0.9f, 1);
  return glm::normalize(glm::dvec3(glm::vec3(far) / far.w - eye_));
}

void FlyCamera::aim(const scenes::Scene& scene) {
  taken_ = false;
  look_from({scene.eye, scene.target});
}

void FlyCamera::follow(const scenes::Scene& scene, double seconds) {
  if (!taken_ && scene.closer) look_from(scenes::view_at(scene, seconds));
}

void FlyCamera::look_from(const scenes::View& view) {
  eye_ = view.eye;
  const glm::vec3 d = glm::normalize(view.target - view.eye);
  yaw_ = std::atan2(d.x, -d.z);
  pitch_ = std::asin(std::clamp(d.y, -1.f, 1.f));
}

glm::vec3 FlyCamera::forward() const {
  return {std::sin(yaw_) * std::cos(pitch_), std::sin(pitch_), -std::cos(yaw_) * std::cos(pitch_)};
}

void FlyCamera::move(float seconds) {
  const auto down = [&](int key) {
    return !ImGui::GetIO().WantTextInput && glfwGetKey(window_, key) == GLFW_PRESS;
  };
  const glm::vec3 ahead = forward(), right = glm::normalize(glm::cross(ahead, glm::vec3(0, 1, 0)));
  const float speed = (down(GLFW_KEY_LEFT_SHIFT) || down(GLFW_KEY_RIGHT_SHIFT) ? 12.f : 4.f) * seconds;
  const auto axis = [&](int plus, int minus) {
    return static_cast<float>(down(plus)) - static_cast<float>(down(minus));
  };
  const glm::vec3 step =
      speed * (axis(GLFW_KEY_W, GLFW_KEY_S) * ahead + axis(GLFW_KEY_D, GLFW_KEY_A) * right +
               axis(GLFW_KEY_E, GLFW_KEY_Q) * glm::vec3(0, 1, 0));
  taken_ |= step != glm::vec3(0);
  eye_ += step;
  eye_.y = std::max(eye_.y, 0.1f);
  double x = 0, y = 0;
  glfwGetCursorPos(window_, &x, &y);
  if (captured_ && had_cursor_) {
    constexpr float kRadiansPerPixel = 0.0025f;
    taken_ |= x != cursor_x_ || y != cursor_y_;
    yaw_ += kRadiansPerPixel * static_cast<float>(x - cursor_x_);
    pitch_ = std::clamp(pitch_ - kRadiansPerPixel * static_cast<float>(y - cursor_y_), -1.5f, 1.5f);
  }
  had_cursor_ = captured_;
  cursor_x_ = x;
  cursor_y_ = y;
}

}  // namespace fracture::app
