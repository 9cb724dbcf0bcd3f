// The surface of a solid as a separate mesh: only positions and triangles.
#pragma once

#include "common/solid/solid.hpp"

namespace fracture::test {

inline Mesh surface_mesh(const Solid& solid) {
  Mesh mesh;
  mesh.positions = solid.positions;
  for (const auto& t : solid.triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  return mesh;
}

}  // namespace fracture::test
