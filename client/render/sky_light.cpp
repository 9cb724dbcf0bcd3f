#include "client/render/sky_light.hpp"

#include <algorithm>
#include <utility>

#include "client/render/gpu_model.hpp"
#include "client/render/programs.hpp"

namespace fracture::render {
namespace {

constexpr int kSide = 128;         // texels; level 0 mirrors clouds, the other levels are smoother
constexpr int kRoughestLevel = 5;  // as in shaders/lighting_high.glsl
constexpr int kFaces = 6;

// OpenGL 3.3, table 3.10: the direction of (s, t, 1) for each face.
const glm::mat3 kFaceDirections[kFaces] = {
    {{0, 0, -1}, {0, -1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
    {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},   {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
    {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
};

Texture make_cube(int levels) {
  Texture cube = make_texture();
  glBindTexture(GL_TEXTURE_CUBE_MAP, cube.get());
  for (int level = 0; level < levels; ++level)
    for (GLenum face = 0; face < kFaces; ++face)
      glTexImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + face, level, GL_RGBA16F, kSide >> level, kSide >> level,
                   0, GL_RGBA, GL_HALF_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_CUBE_MAP, GL_TEXTURE_MAX_LEVEL, levels - 1);
  return cube;
}

}  // namespace

Expected<SkyLight> SkyLight::create() {
  SkyLight light;
  Expected<Program> source = build_program("sky source", Tier::kHigh, {"screen_vertex"},
                                           {"frame", "brdf", "noise", "sky", "sky_source_fragment"});
  if (!source) return tl::unexpected(source.error());
  light.source_program_ = std::move(*source);
  Expected<Program> blur =
      build_program("sky blur", Tier::kHigh, {"screen_vertex"}, {"brdf", "sky_blur_fragment"});
  if (!blur) return tl::unexpected(blur.error());
  light.blur_program_ = std::move(*blur);
  light.blur_program_.set("sky_source", kSkyMap);
  light.empty_ = make_vertex_array();
  light.framebuffer_ = make_framebuffer();
  glActiveTexture(GL_TEXTURE0 + kSkyMap);
  int levels = 1;
  while ((kSide >> levels) > 0) ++levels;
  light.source_ = make_cube(levels);
  light.blurred_ = make_cube(kRoughestLevel + 1);
  glBindFramebuffer(GL_FRAMEBUFFER, light.framebuffer_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_CUBE_MAP_POSITIVE_X,
                         light.blurred_.get(), 0);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    return fail(ErrorCode::kGraphicsDriver, "The driver refuses a texture for the reflected sky.");
  return light;
}

void SkyLight::draw_face(GLuint cube, int face, int level, int side) const {
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                         GL_TEXTURE_CUBE_MAP_POSITIVE_X + static_cast<GLenum>(face), cube, level);
  glViewport(0, 0, side, side);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void SkyLight::update(const FrameBlock& frame) {
  const std::array<glm::vec4, 4> now = {
      glm::vec4(glm::vec3(frame.towards_sun), 0), glm::vec4(glm::vec3(frame.sun), 0),
      glm::vec4(glm::vec3(frame.sky), 0), glm::vec4(glm::vec3(frame.plane), 0)};
  glActiveTexture(GL_TEXTURE0 + kSkyMap);
  if (drawn_ == now) {
    glBindTexture(GL_TEXTURE_CUBE_MAP, blurred_.get());
    return;
  }
  drawn_ = now;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glBindVertexArray(empty_.get());
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  const auto face_of = [](const Program& program, int face) {
    glUniformMatrix3fv(program.location("face"), 1, GL_FALSE, &kFaceDirections[face][0][0]);
  };
  source_program_.use();
  source_program_.set("side", kSide);
  for (int face = 0; face < kFaces; ++face) {
    face_of(source_program_, face);
    draw_face(source_.get(), face, 0, kSide);
  }
  glBindTexture(GL_TEXTURE_CUBE_MAP, source_.get());
  glGenerateMipmap(GL_TEXTURE_CUBE_MAP);
  blur_program_.use();
  blur_program_.set("source_side", kSide);
  for (int level = 0; level <= kRoughestLevel; ++level) {
    constexpr float kSmoothest = 0.06f;  // the mirrored lobe is then a texel wide
    blur_program_.set("side", kSide >> level);
    blur_program_.set("roughness", std::max(kSmoothest, static_cast<float>(level) / kRoughestLevel));
    for (int face = 0; face < kFaces; ++face) {
      face_of(blur_program_, face);
      draw_face(blurred_.get(), face, level, kSide >> level);
    }
  }
  glBindTexture(GL_TEXTURE_CUBE_MAP, blurred_.get());
}

}  // namespace fracture::render
