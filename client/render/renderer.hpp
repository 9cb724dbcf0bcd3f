// Draws models into the bound framebuffer: sun with a soft shadow map, sky with shadows of its own, a ground,
// and glTF 2.0's metallic-roughness materials. It makes no context and no window: one with OpenGL 3.3 core
// has to be current, made by EGL (client/headless) or by a window, from construction to destruction.
//
// A frame is: table of objects → sun depth → sky depths → background, opaque surfaces, ground, blended
// surfaces (their back faces, then their front faces: for closed fragments of one glass the order among them
// changes little, as absorption multiplies). Neighbouring surfaces of one material are one draw call. That is the low
// tier; high_picture.hpp says what the high one does after the depths of sun and sky.
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
/// What covers the materials: nothing, or plain grey outside and orange inside.
enum class Highlight { kNone, kInterior };

struct Lighting {
  glm::vec3 towards_sun{0.45f, 0.8f, 0.5f};  ///< any length
  glm::vec3 sun{2.9f, 2.75f, 2.5f};          ///< irradiance on a surface that faces it, linear
  glm::vec3 sky{0.47f, 0.52f, 0.60f};        ///< radiance from above, linear
  glm::vec3 ground{0.26f, 0.25f, 0.24f};     ///< radiance from below
  float sun_softness = 2.0f;                 ///< radius of the penumbra filter in texels of the sun's map
  int sky_shadows = 32;  ///< directions, 0 … kMaxSkyDirections; 0: the sky throws no shadow
  bool sun_shadow = true;
  float exposure = 1.0f;
};

struct RenderSettings {
  Lighting lighting;
  Ground ground = Ground::kPlane;
  std::optional<float> ground_height;            ///< y, metres; the lowest point of the model when empty
  glm::vec3 ground_color{0.34f, 0.345f, 0.36f};  ///< linear
  bool background = true;                        ///< false: transparent black
  glm::vec3 background_top{0.17f, 0.20f, 0.25f},
      background_bottom{0.42f, 0.43f, 0.45f};  ///< as shown, linear
  Highlight highlight = Highlight::kNone;
  SolidLook look = SolidLook::kNone;  ///< a material for everything, by a solid texture (looks.hpp)
  glm::vec3 grain{0, 1, 0};           ///< of a look that has one
  /// What light and shadow maps cover, and the middle of the ground; around all visible objects when empty.
  std::optional<Sphere> lit;
  bool wireframe = false;  ///< edges of the surfaces alone
  Tier tier = Tier::kLow;  ///< high draws a sky instead of the background's colours, and no edges
  /// Called with the framebuffer that more can be drawn into, after all surfaces and, in the high tier, before what is done
  /// to the picture as a whole: there it takes light, not colours.
  std::function<void(GLuint framebuffer)> overlay{};
};

/// One of several models that stand in the same picture, with a look of its own.
struct DrawItem {
  GpuModel* model = nullptr;
  std::span<const ObjectState> states;  ///< one for each object
  SolidLook look = SolidLook::kNone;
  glm::vec3 grain{0, 1, 0};  ///< of objects without a placement of their own
  /// One for each object, or empty: 1 where its interior surfaces are not drawn (they throw shadows all the same).
  std::span<const std::uint8_t> uncut{};
};

struct FrameStats {
  std::size_t draw_calls = 0;         ///< of the visible pass
  std::size_t shadow_draw_calls = 0;  ///< of the depth passes: a few for each shadow map
  std::size_t surfaces = 0;           ///< drawn in the visible pass
  std::size_t culled = 0;             ///< outside the view
  Tier tier = Tier::kLow;             ///< that was drawn
};

struct FrameBlock;
class HighPicture;

class Renderer {
 public:
  /// kNoDevice below OpenGL 3.3, kGl where a shader or a map is refused.
  static Expected<Renderer> create();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// Draws into `framebuffer`, of width × height pixels, and clears it first. `states` has one for each
  /// object. Where the driver refuses the high tier, the low one is drawn, and trouble() says why.
  FrameStats draw(GpuModel& model, std::span<const ObjectState> states, const Camera& camera,
                  const RenderSettings& settings, GLuint framebuffer, int width, int height);
  /// Several models in one picture; the looks of the items replace that of the settings.
  FrameStats draw(std::span<const DrawItem> items, const Camera& camera, const RenderSettings& settings,
                  GLuint framebuffer, int width, int height);

  const std::optional<Error>& trouble() const { return trouble_; }

 private:
  Renderer();
  void upload_frame(const FrameBlock& frame) const;
  void depth_passes(std::span<const DrawItem> items, const RenderSettings& settings, Tier tier,
                    FrameStats& stats);
  void draw_ground(const RenderSettings& settings) const;
  bool prepare_high(int width, int height);  ///< false: trouble()

  Program surface_, depth_, ground_, background_;
  Buffer frame_block_;
  VertexArray empty_;
  std::optional<ShadowMaps> shadows_;
  std::unique_ptr<HighPicture> high_;  ///< once it was asked for
  std::optional<Error> trouble_;
};

}  // namespace fracture::render
