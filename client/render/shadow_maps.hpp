// What the lights see: one depth map for the sun, and a stack of small ones for the sky. A point's share of
// the sky is the share of the stack's directions in which nothing stands in its way: soft contact shadows and
// dark cracks without noise, for as many depth passes as there are directions (Whitehurst, "Depth Map Based
// Ambient Occlusion Lighting", 2003; there the lights are accumulated picture by picture, here all are looked
// up in one pass).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "client/render/gl_objects.hpp"
#include "client/render/model.hpp"

namespace fracture::render {

inline constexpr int kMaxSkyDirections = 64;  ///< as in shaders/frame.glsl

/// From the world to a depth map: x, y, z in 0 … 1 inside the sphere.
glm::mat4 light_matrix(const Sphere& sphere, const glm::vec3& towards_light);

/// Directions of the upper hemisphere, evenly spread (a Fibonacci spiral), none of them nearly horizontal.
std::vector<glm::vec3> sky_directions(int count);

class ShadowMaps {
 public:
  /// kGl where the driver refuses a map.
  static Expected<ShadowMaps> create(int sun_side = 2048, int sky_side = 512,
                                     int sky_count = kMaxSkyDirections);

  /// Makes the map the target of the depth pass that follows and clears it.
  void begin_sun() const;
  void begin_sky(int direction) const;
  /// Of the high tier: a second map of the sun, for what lets light through; and the first one's depths as numbers. kGraphicsDriver.
  Expected<void> add_clear();
  void begin_clear() const;
  void bind() const;  ///< all there are, to their texture units
  int sun_side() const { return sun_side_; }
  int sky_side() const { return sky_side_; }
  int sky_count() const { return sky_count_; }

 private:
  ShadowMaps() = default;
  void begin_map(const Texture& map) const;
  int sun_side_ = 0, sky_side_ = 0, sky_count_ = 0;
  Texture sun_, sky_, clear_;
  Sampler depths_;  ///< reads a map without comparison
  Framebuffer framebuffer_;
};

}  // namespace fracture::render
