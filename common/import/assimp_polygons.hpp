// Divides the polygons of an Assimp scene like those of our own readers (polygon_triangles.hpp). Assimp chooses other diagonals,
// so that bent polygons give a different solid than in other tools.
#pragma once

#include <assimp/scene.h>

namespace fracture {

/// Replaces the polygons of the scene by fans, except flat ones with a reflex corner, which are left to Assimp's ear cutting.
void fan_polygons(aiScene& scene);

}  // namespace fracture
