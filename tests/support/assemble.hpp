// Helpers that build the generated meshes.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "common/mesh/mesh.hpp"

namespace fracture::test {

inline Vec3f to_float(const Vec3d& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

/// Adds the quad a b c d (counter-clockwise) as two triangles.
inline void add_quad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

/// Gives all triangles one node and no material.
inline void finish(Mesh& mesh, std::string node = "shape") {
  mesh.material.assign(mesh.triangles.size(), kNoIndex);
  mesh.node.assign(mesh.triangles.size(), 0);
  mesh.node_names = {std::move(node)};
}

}  // namespace fracture::test
