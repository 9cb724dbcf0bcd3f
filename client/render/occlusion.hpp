// Ambient occlusion of the picture, from its depth (shaders/occlusion_fragment.glsl names the paper).
#pragma once

#include "client/render/camera.hpp"
#include "client/render/high_targets.hpp"

namespace fracture::render {

class Occlusion {
 public:
  /// kGraphicsDriver where a shader is refused.
  static Expected<Occlusion> create();
  /// From targets.scene_depth into targets.occlusion; both are left at their texture units. The frame block has to be bound.
  void draw(const HighTargets& targets, const Camera& camera) const;

 private:
  Occlusion() = default;
  Program raw_, blur_;
  VertexArray empty_;
};

}  // namespace fracture::render
