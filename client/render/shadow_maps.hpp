// Depth maps of the lights: one for the sun, and a stack of small ones for the sky. The share of the sky that
// lights a point is the share of the stack's directions that are not blocked. This gives soft contact shadows
// and dark cracks without noise, for one depth pass per direction (Whitehurst, "Depth Map Based Ambient
// Occlusion Lighting", 2003; there the lights are accumulated picture by picture, here all are looked up in
// one pass).
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "client/render/gl_objects.hpp"
#include "client/render/model.hpp"

namespace fracture::render {

inline constexpr int kMaxSkyDirections = 64;  ///< as in shaders/frame.glsl

/// Transforms from the world to a depth map: x, y, z in 0 … 1 inside the sphere.
glm::mat4 light_matrix(const Sphere& sphere, const glm::vec3& towards_light);

/// Evenly spread directions of the upper hemisphere (a Fibonacci spiral), none of them nearly horizontal.
std::vector<glm::vec3> sky_directions(int count);

class ShadowMaps {
 public:
  /// kGraphicsDriver if the driver rejects a map.
  static Expected<ShadowMaps> create(int sun_side = 2048, int sky_side = 512,
                                     int sky_count = kMaxSkyDirections);

  /// Makes the map the target of the next depth pass and clears it.
  void begin_sun() const;
  void begin_sky(int direction) const;
  /// For the high tier: adds a second map of the sun for casters that let light through, and reads the first
  /// map's depths as numbers. kGraphicsDriver.
  Expected<void> add_clear();
  void begin_clear() const;
  void bind() const;  ///< binds all maps to their texture units
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
