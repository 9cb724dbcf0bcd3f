// Divides polygons as most tools do: a fan from the first corner, like common OBJ readers. Assimp chooses
// other diagonals, so that bent polygons give a different solid than in other tools. Flat polygons with a
// reflex corner are the exception, because a fan is wrong for them. They are left to Assimp's ear cutting.
#pragma once

#include <assimp/scene.h>

namespace fracture {

/// Replaces the polygons of the scene by fans, except flat ones with a reflex corner (flat: within kFlat of
/// their extent).
inline constexpr double kFlat = 1e-3;
void fan_polygons(aiScene& scene);

}  // namespace fracture
