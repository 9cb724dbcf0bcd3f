#include "client/render/occlusion.hpp"

#include <utility>

#include "client/render/gpu_model.hpp"
#include "client/render/programs.hpp"

namespace fracture::render {

Expected<Occlusion> Occlusion::create() {
  Occlusion occlusion;
  Expected<Program> raw =
      build_program("occlusion", Tier::kHigh, {"screen_vertex"}, {"frame", "brdf", "occlusion_fragment"});
  if (!raw) return tl::unexpected(raw.error());
  occlusion.raw_ = std::move(*raw);
  Expected<Program> blur =
      build_program("occlusion blur", Tier::kHigh, {"screen_vertex"}, {"occlusion_blur_fragment"});
  if (!blur) return tl::unexpected(blur.error());
  occlusion.blur_ = std::move(*blur);
  occlusion.blur_.set("raw_occlusion", kScreenOcclusion);
  occlusion.empty_ = make_vertex_array();
  return occlusion;
}

void Occlusion::draw(const HighTargets& targets, const Camera& camera) const {
  const glm::mat4 inverse = glm::inverse(camera.projection);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glBindVertexArray(empty_.get());
  glActiveTexture(GL_TEXTURE0 + kSceneDepth);
  glBindTexture(GL_TEXTURE_2D, targets.scene_depth.texture.get());
  targets.raw_occlusion.begin();
  raw_.use();
  glUniformMatrix4fv(raw_.location("projection"), 1, GL_FALSE, &camera.projection[0][0]);
  glUniformMatrix4fv(raw_.location("inverse_projection"), 1, GL_FALSE, &inverse[0][0]);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glActiveTexture(GL_TEXTURE0 + kScreenOcclusion);
  glBindTexture(GL_TEXTURE_2D, targets.raw_occlusion.texture.get());
  targets.occlusion.begin();
  blur_.use();
  glUniformMatrix4fv(blur_.location("inverse_projection"), 1, GL_FALSE, &inverse[0][0]);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D, targets.occlusion.texture.get());
}

}  // namespace fracture::render
