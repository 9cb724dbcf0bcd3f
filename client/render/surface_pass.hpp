// The surfaces of a picture's models as draw calls: neighbouring surfaces of one material are one.
#pragma once

#include "client/render/renderer.hpp"

namespace fracture::render {

/// Which surfaces a pass draws, with what.
struct SurfacePass {
  enum class Sides {
    kOfMaterial,     ///< both of double-sided materials, else the front
    kBackThenFront,  ///< for blending
    kBack,
    kFront
  };
  const Program& program;  ///< with the uniforms of surface_fragment.glsl, or some of them
  bool blended = false;    ///< these, or the others
  Sides sides = Sides::kOfMaterial;
};

/// Counts what is drawn and what is out of sight. The program is in use afterwards.
void draw_surfaces(const SurfacePass& pass, const DrawItem& item, const Camera& camera,
                   const RenderSettings& settings, FrameStats& stats);

/// What throws a shadow into a map. Where a map has all, what is blended keeps back its share of the light by leaving out
/// pixels; in one of its own it is whole.
enum class Casters { kAll, kOpaque, kClear };

/// Into the map that is bound. map: -1 the sun's, else a direction of the sky. `depth` has to be in use.
void draw_depth(const Program& depth, const DrawItem& item, const RenderSettings& settings, int map,
                Casters casters, FrameStats& stats);

/// Is there anything blended in sight?
bool any_blended(std::span<const DrawItem> items, const RenderSettings& settings);

}  // namespace fracture::render
