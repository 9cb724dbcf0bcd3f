// Quads as everybody cuts them: along the diagonal from the first corner, as OBJ readers commonly do. Assimp
// picks another diagonal where the fan looks concave from one side, which on bent quads makes another solid
// than other tools see.
#pragma once

#include <assimp/scene.h>

namespace fracture {

/// Replaces every quad of the scene by the two triangles (0, 1, 2), (0, 2, 3), or (1, 2, 3), (1, 3, 0) where
/// only that diagonal keeps both triangles facing the same way. Larger polygons stay for
/// aiProcess_Triangulate.
void fan_quads(aiScene& scene);

}  // namespace fracture
