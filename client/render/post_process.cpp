#include "client/render/post_process.hpp"

#include <utility>

#include "client/render/programs.hpp"

namespace fracture::render {
namespace {

constexpr int kSource = 0, kBloom = 1;  // texture units that are free, because no more surfaces are drawn

void read(int unit, GLenum target, const Texture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture.get());
}

}  // namespace

Expected<PostProcess> PostProcess::create() {
  PostProcess post;
  const auto build = [&](Program& program, const char* name, ShaderParts fragment) -> Expected<void> {
    Expected<Program> made = build_program(name, Tier::kHigh, {"screen_vertex"}, fragment);
    if (!made) return tl::unexpected(made.error());
    program = std::move(*made);
    for (const char* source : {"source", "samples"}) program.set(source, kSource);
    program.set("bloom", kBloom);
    return {};
  };
  Expected<void> built = build(post.resolve_, "resolve", {"resolve_fragment"});
  if (built) built = build(post.down_, "bloom down", {"bloom_down_fragment"});
  if (built) built = build(post.up_, "bloom up", {"bloom_up_fragment"});
  if (built) built = build(post.finish_, "finish", {"tone_map", "finish_fragment"});
  if (built) built = build(post.antialias_, "antialias", {"frame", "antialias_fragment"});
  if (!built) return tl::unexpected(built.error());
  post.empty_ = make_vertex_array();
  return post;
}

std::size_t PostProcess::draw(const HighTargets& targets, GLuint framebuffer) const {
  // Sunlit white is at most 1.3. Only mirrored light is brighter and glares.
  constexpr float kGlaring = 1.7f, kDearest = 8.f;
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glBindVertexArray(empty_.get());
  std::size_t calls = 0;
  const auto all = [&](const Layer& into) {
    into.begin();
    glDrawArrays(GL_TRIANGLES, 0, 3);
    ++calls;
  };
  resolve_.use();
  resolve_.set("count", targets.samples);
  read(kSource, GL_TEXTURE_2D_MULTISAMPLE, targets.light);
  all(targets.behind);
  read(kSource, GL_TEXTURE_2D, targets.behind.texture);
  glGenerateMipmap(GL_TEXTURE_2D);
  down_.use();
  down_.set("dearest", kDearest);
  for (std::size_t k = 0; k < targets.bloom.size(); ++k) {
    down_.set("threshold", k == 0 ? kGlaring : 0.f);
    read(kSource, GL_TEXTURE_2D, k == 0 ? targets.behind.texture : targets.bloom[k - 1].texture);
    all(targets.bloom[k]);
  }
  up_.use();
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  for (std::size_t k = targets.bloom.size(); --k > 0;) {
    read(kSource, GL_TEXTURE_2D, targets.bloom[k].texture);
    all(targets.bloom[k - 1]);
  }
  glDisable(GL_BLEND);
  finish_.use();
  read(kSource, GL_TEXTURE_2D, targets.behind.texture);
  read(kBloom, GL_TEXTURE_2D, targets.bloom.front().texture);
  all(targets.shown);
  antialias_.use();
  read(kSource, GL_TEXTURE_2D, targets.shown.texture);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, targets.width, targets.height);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  return calls + 1;
}

}  // namespace fracture::render
