// Where the fragments stand in a picture, and in which colour: the views of the gallery. Pure functions of
// the model; no OpenGL and no physics (the game client has its own).
#pragma once

#include <optional>
#include <vector>

#include "client/render/camera.hpp"
#include "client/render/model.hpp"

namespace fracture::render {

enum class View {
  kAssembled,  ///< as the file places them
  kExploded,   ///< away from the common centre by a factor of their distance from it
  kImpact,     ///< those near a point bursting from below it, as a snapshot of their flight
};

enum class Colors {
  kMaterial,
  kFragment,  ///< a colour for each fragment, by its place in the file
  kLevel,     ///< a colour for each group of the hierarchy
};

struct ViewOptions {
  View view = View::kAssembled;
  Colors colors = Colors::kMaterial;
  float explode = 0.45f;  ///< 0 … 10; 1 doubles every distance from the centre
  int level = 0;          ///< of the hierarchy, 0 the coarsest: for kLevel, and for `by_group`
  bool by_group = false;  ///< kExploded moves groups of the level, not fragments
  std::optional<glm::vec3> impact_point;  ///< metres; where the camera's axis meets the object when empty
  std::optional<float> impact_radius;     ///< metres; 0.55 of the bounding sphere's radius when empty
  glm::vec3 impact_direction{0};          ///< of what hits; away from the camera when zero
  float impact_strength = 1;
};

/// States of all objects for the view. `placement` is the camera the defaults refer to.
std::vector<ObjectState> view_states(const Model& model, const ViewOptions& options,
                                     const CameraPlacement& placement);

/// The first point of the model (as the file places it) on a ray; nothing where it passes by.
std::optional<glm::vec3> first_hit(const Model& model, const glm::vec3& origin, const glm::vec3& direction);

/// A colour that tells neighbours in number apart: hues a golden ratio apart, linear rgb.
glm::vec3 distinct_color(std::uint32_t number);

}  // namespace fracture::render
