// Draws the surfaces of a picture's models. Neighbouring surfaces with one material share a draw call.
#pragma once

#include "client/render/renderer.hpp"

namespace fracture::render {

/// The surfaces that a pass draws, and its program.
struct SurfacePass {
  enum class Sides {
    kOfMaterial,     ///< both for double-sided materials, otherwise the front
    kBackThenFront,  ///< for blending
    kBack,
    kFront
  };
  const Program& program;  ///< with the uniforms of surface_fragment.glsl, or some of them
  bool blended = false;    ///< draws blended surfaces; false: all others
  Sides sides = Sides::kOfMaterial;
};

/// Draws the item's surfaces. Counts those drawn and those outside the view. Leaves the program in use.
void draw_surfaces(const SurfacePass& pass, const DrawItem& item, const Camera& camera,
                   const RenderSettings& settings, FrameStats& stats);

/// The casters in a shadow map. In a map for all, blended casters block their share of the light by leaving
/// out pixels. In their own map, they are complete.
enum class Casters { kAll, kOpaque, kClear };

/// Draws into the bound map. map: -1 for the sun, otherwise a direction of the sky. `depth` must be in use.
void draw_depth(const Program& depth, const DrawItem& item, const RenderSettings& settings, int map,
                Casters casters, FrameStats& stats);

/// Whether a blended surface is in view.
bool any_blended(std::span<const DrawItem> items, const RenderSettings& settings);

}  // namespace fracture::render
