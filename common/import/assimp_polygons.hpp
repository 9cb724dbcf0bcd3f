// Polygons as everybody cuts them: a fan from the first corner, as OBJ readers commonly do. Assimp picks
// other diagonals, which on bent polygons makes another solid than other tools see. Only flat polygons with a
// reflex corner have one right triangulation, and it is not the fan: those stay for Assimp's ear cutting.
#pragma once

#include <assimp/scene.h>

namespace fracture {

/// Replaces the polygons of the scene by fans, flat ones with a reflex corner excepted (flat: within kFlat of
/// their extent).
inline constexpr double kFlat = 1e-3;
void fan_polygons(aiScene& scene);

}  // namespace fracture
