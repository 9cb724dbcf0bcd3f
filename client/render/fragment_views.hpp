// The positions and colours of fragments in the gallery's views. They depend only on the model and use no
// OpenGL and no physics. The game client has its own.
#pragma once

#include <optional>
#include <vector>

#include "client/render/camera.hpp"
#include "client/render/model.hpp"

namespace fracture::render {

enum class View {
  kAssembled,  ///< as the file places them
  kExploded,   ///< moved away from the common centre, in proportion to their distance from it
  kImpact,     ///< fragments near a point burst away from below it, as a snapshot of their flight
};

enum class Colors {
  kMaterial,
  kFragment,  ///< a colour for each fragment, by its position in the file
  kLevel,     ///< a colour for each group of the hierarchy
};

struct ViewOptions {
  View view = View::kAssembled;
  Colors colors = Colors::kMaterial;
  float explode = 0.45f;                  ///< 0 … 10; 1 doubles every distance from the centre
  int level = 0;                          ///< of the hierarchy, 0 is the coarsest; for kLevel and `by_group`
  bool by_group = false;                  ///< kExploded moves groups of that level instead of fragments
  std::optional<glm::vec3> impact_point;  ///< metres; empty: where the camera's axis meets the object
  std::optional<float> impact_radius;     ///< metres; empty: 0.55 of the bounding sphere's radius
  glm::vec3 impact_direction{0};          ///< direction of the hitting object; zero: away from the camera
  float impact_strength = 1;
};

/// States of all objects for the view. `placement`: the camera to which the defaults refer.
std::vector<ObjectState> view_states(const Model& model, const ViewOptions& options,
                                     const CameraPlacement& placement);

/// The first point on a ray that belongs to the model (as the file places it), or nothing.
std::optional<glm::vec3> first_hit(const Model& model, const glm::vec3& origin, const glm::vec3& direction);

/// A colour that differs from those of nearby numbers: hues a golden ratio apart, linear rgb.
glm::vec3 distinct_color(std::uint32_t number);

}  // namespace fracture::render
