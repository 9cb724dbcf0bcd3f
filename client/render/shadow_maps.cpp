#include "client/render/shadow_maps.hpp"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <string>

#include "client/render/gpu_model.hpp"

namespace fracture::render {
namespace {

void set_depth_parameters(GLenum target) {
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  glTexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  constexpr float kFar[4] = {1, 1, 1, 1};  // beyond the map, nothing blocks the light
  glTexParameterfv(target, GL_TEXTURE_BORDER_COLOR, kFar);
  glTexParameteri(target, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(target, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

}  // namespace

glm::mat4 light_matrix(const Sphere& sphere, const glm::vec3& towards_light) {
  const float r = sphere.radius > 0 ? sphere.radius : 1.f;
  const glm::vec3 up = std::abs(towards_light.y) > 0.99f ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0);
  const glm::mat4 view = glm::lookAt(sphere.center + 2 * r * towards_light, sphere.center, up);
  const glm::mat4 projection = glm::ortho(-r, r, -r, r, 0.9f * r, 3.1f * r);
  return glm::translate(glm::mat4(1), glm::vec3(0.5f)) * glm::scale(glm::mat4(1), glm::vec3(0.5f)) *
         projection * view;
}

std::vector<glm::vec3> sky_directions(int count) {
  std::vector<glm::vec3> directions;
  const float golden_angle = glm::pi<float>() * (3 - std::sqrt(5.f));
  for (int k = 0; k < count; ++k) {
    const float y = 0.08f + 0.92f * (static_cast<float>(k) + 0.5f) / static_cast<float>(count);
    const float angle = golden_angle * static_cast<float>(k), r = std::sqrt(1 - y * y);
    directions.emplace_back(r * std::cos(angle), y, r * std::sin(angle));
  }
  return directions;
}

Expected<ShadowMaps> ShadowMaps::create(int sun_side, int sky_side, int sky_count) {
  ShadowMaps maps;
  maps.sun_side_ = sun_side;
  maps.sky_side_ = sky_side;
  maps.sky_count_ = sky_count;
  maps.sun_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, maps.sun_.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, sun_side, sun_side, 0, GL_DEPTH_COMPONENT,
               GL_UNSIGNED_INT, nullptr);
  set_depth_parameters(GL_TEXTURE_2D);
  maps.sky_ = make_texture();
  glBindTexture(GL_TEXTURE_2D_ARRAY, maps.sky_.get());
  glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT16, sky_side, sky_side, sky_count, 0,
               GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT, nullptr);
  set_depth_parameters(GL_TEXTURE_2D_ARRAY);
  maps.framebuffer_ = make_framebuffer();
  maps.begin_sun();
  if (const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER); status != GL_FRAMEBUFFER_COMPLETE)
    return fail(ErrorCode::kGraphicsDriver, "The driver refuses a shadow map of " + std::to_string(sun_side) +
                                                " x " + std::to_string(sun_side) + " texels (status " +
                                                std::to_string(status) + ").");
  return maps;
}

void ShadowMaps::begin_sun() const { begin_map(sun_); }

void ShadowMaps::begin_map(const Texture& map) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, map.get(), 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  glViewport(0, 0, sun_side_, sun_side_);
  glClear(GL_DEPTH_BUFFER_BIT);
}

void ShadowMaps::begin_sky(int direction) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, sky_.get(), 0, direction);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  glViewport(0, 0, sky_side_, sky_side_);
  glClear(GL_DEPTH_BUFFER_BIT);
}

Expected<void> ShadowMaps::add_clear() {
  if (clear_.get() != 0) return {};
  clear_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, clear_.get());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, sun_side_, sun_side_, 0, GL_DEPTH_COMPONENT,
               GL_UNSIGNED_INT, nullptr);
  set_depth_parameters(GL_TEXTURE_2D);
  depths_ = make_sampler();
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glSamplerParameteri(depths_.get(), filter, GL_NEAREST);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glSamplerParameteri(depths_.get(), wrap, GL_CLAMP_TO_EDGE);
  begin_clear();
  if (const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER); status != GL_FRAMEBUFFER_COMPLETE)
    return fail(ErrorCode::kGraphicsDriver,
                "The driver refuses a second shadow map (status " + std::to_string(status) + ").");
  return {};
}

void ShadowMaps::begin_clear() const { begin_map(clear_); }

void ShadowMaps::bind() const {
  glActiveTexture(GL_TEXTURE0 + kSunShadow);
  glBindTexture(GL_TEXTURE_2D, sun_.get());
  glActiveTexture(GL_TEXTURE0 + kSkyShadows);
  glBindTexture(GL_TEXTURE_2D_ARRAY, sky_.get());
  if (clear_.get() == 0) return;
  glActiveTexture(GL_TEXTURE0 + kClearShadow);
  glBindTexture(GL_TEXTURE_2D, clear_.get());
  glActiveTexture(GL_TEXTURE0 + kSunDepths);
  glBindTexture(GL_TEXTURE_2D, sun_.get());
  glBindSampler(kSunDepths, depths_.get());
}

}  // namespace fracture::render
