// Draws models into the bound framebuffer: a sun with a soft shadow map, a sky with its own shadows, a ground,
// and glTF 2.0's metallic-roughness materials. It creates neither a context nor a window: an OpenGL 3.3 core context,
// from EGL (client/egl) or a window, must be current from construction to destruction.
//
// A frame consists of: table of objects → sun depth → sky depths → background, opaque surfaces, ground, blended
// surfaces (back faces, then front faces; for closed fragments of the same glass their order matters
// little, because absorption multiplies). Adjacent surfaces with the same material are one draw call. This is the low
// tier; high_picture.hpp describes what the high tier does after the sun and sky depths.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>

#include "client/render/camera.hpp"
#include "client/render/gpu_model.hpp"
#include "client/render/looks.hpp"
#include "client/render/shadow_maps.hpp"
#include "client/render/tier.hpp"

namespace fracture::render {

enum class Ground { kNone, kPlane, kGrid };
/// Replaces the materials: nothing, or plain grey outside and orange inside.
enum class Highlight { kNone, kInterior };

struct Lighting {
  glm::vec3 towards_sun{0.45f, 0.8f, 0.5f};  ///< any length
  glm::vec3 sun{2.9f, 2.75f, 2.5f};          ///< irradiance on a surface facing the sun, linear
  glm::vec3 sky{0.47f, 0.52f, 0.60f};        ///< radiance from above, linear
  glm::vec3 ground{0.26f, 0.25f, 0.24f};     ///< radiance from below
  float sun_softness = 2.0f;  ///< radius of the penumbra filter in texels of the sun's shadow map
  int sky_shadows = 32;       ///< number of directions, 0 … kMaxSkyDirections; 0: the sky casts no shadow
  bool sun_shadow = true;
  float exposure = 1.0f;
};

struct RenderSettings {
  Lighting lighting;
  Ground ground = Ground::kPlane;
  std::optional<float> ground_height;            ///< y in metres; if empty, the lowest point of the model
  glm::vec3 ground_color{0.34f, 0.345f, 0.36f};  ///< linear
  bool background = true;                        ///< false: transparent black
  glm::vec3 background_top{0.17f, 0.20f, 0.25f},
      background_bottom{0.42f, 0.43f, 0.45f};  ///< as shown, linear
  Highlight highlight = Highlight::kNone;
  SolidLook look = SolidLook::kNone;  ///< a solid texture that replaces every material (looks.hpp)
  glm::vec3 grain{0, 1, 0};           ///< for looks that have a grain
  /// The region covered by light and shadow maps, and the centre of the ground. If empty: around all visible
  /// objects.
  std::optional<Sphere> lit;
  bool wireframe = false;  ///< only the edges of the surfaces
  Tier tier = Tier::kLow;  ///< high draws a sky instead of the background colours, and no edges
  /// Called with the framebuffer, to draw more into it: after all surfaces and, in the high tier, before
  /// post-processing, when the framebuffer contains light instead of colours.
  std::function<void(GLuint framebuffer)> overlay{};
};

/// One of several models in the same picture, each with its own look.
struct DrawItem {
  GpuModel* model = nullptr;
  std::span<const ObjectState> states;  ///< one per object
  SolidLook look = SolidLook::kNone;
  glm::vec3 grain{0, 1, 0};  ///< for objects without their own placement
  /// One per object, or empty: 1 if the object's interior surfaces are not drawn (they still cast shadows).
  std::span<const std::uint8_t> uncut{};
};

struct FrameStats {
  std::size_t draw_calls = 0;         ///< in the visible pass
  std::size_t shadow_draw_calls = 0;  ///< in the depth passes: a few per shadow map
  std::size_t surfaces = 0;           ///< drawn in the visible pass
  std::size_t culled = 0;             ///< outside the view
  Tier tier = Tier::kLow;             ///< the tier that was drawn
};

struct FrameBlock;
class HighPicture;

class Renderer {
 public:
  /// Fails with kNoGraphics below OpenGL 3.3, and kGraphicsDriver if the driver refuses a shader or shadow map.
  static Expected<Renderer> create();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// Clears `framebuffer`, which has width × height pixels, and draws into it. `states` has one entry per
  /// object. If the driver refuses the high tier, the low one is drawn, and trouble() explains why.
  FrameStats draw(GpuModel& model, std::span<const ObjectState> states, const Camera& camera,
                  const RenderSettings& settings, GLuint framebuffer, int width, int height);
  /// Draws several models in one picture; the items' looks replace the look in the settings.
  FrameStats draw(std::span<const DrawItem> items, const Camera& camera, const RenderSettings& settings,
                  GLuint framebuffer, int width, int height);

  const std::optional<Error>& trouble() const { return trouble_; }

 private:
  Renderer();
  void upload_frame(const FrameBlock& frame) const;
  void depth_passes(std::span<const DrawItem> items, const RenderSettings& settings, Tier tier,
                    FrameStats& stats);
  void draw_ground(const RenderSettings& settings) const;
  bool prepare_high(int width, int height);  ///< false: see trouble()

  Program surface_, depth_, ground_, background_;
  Buffer frame_block_;
  VertexArray empty_;
  std::optional<ShadowMaps> shadows_;
  std::unique_ptr<HighPicture> high_;  ///< set once it is requested
  std::optional<Error> trouble_;
};

}  // namespace fracture::render
