// The built-in meshes: closed surfaces made of boxes and turned profiles, with flat or smooth normals.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace fracture::scenes {

/// Triangles are counter-clockwise seen from outside. Corners at the same place have bit-identical positions.
struct SurfaceMesh {
  std::vector<glm::vec3> positions, normals;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  /// Adds a flat quadrilateral; a, b, c, d are counter-clockwise.
  void quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);
  void triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);
};

/// A box around the origin. Its edges are cut off by `bevel` metres (0: sharp).
SurfaceMesh box(const glm::vec3& size, float bevel = 0);

/// A crate: a cube with a sunken panel on each side, hollow inside. `wall` < `border` < side / 2.
SurfaceMesh crate(float side, float border, float depth, float wall);

/// A profile of (radius, height) points, from the bottom up, turned around y and closed with discs. `flutes`
/// > 0 cuts grooves `groove` metres deep between the two heights. `segments` must be a multiple of 4, and
/// with flutes also of 2·flutes.
struct Turned {
  std::vector<glm::vec2> profile;
  int segments = 32, flutes = 0;
  float groove = 0, fluted_from = 0, fluted_to = 0;
};
SurfaceMesh turned(const Turned& shape);

/// A binary glTF with this mesh and one material of this colour (linear).
std::string to_glb(const SurfaceMesh& mesh, const std::string& name, const glm::vec4& color);

}  // namespace fracture::scenes
