// Families of meshes and sites in any size. The growing quantity is chosen so that input and output grow in
// proportion to it. Something in between (pairs of parts, regions of a cap, neighbours of a cell, crossings
// of a loop) could grow faster. bench_growth measures the families, and fuzz_fracture takes small ones.
//
// Only basic arithmetic and square roots are used, so a seed gives the same input everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace fracture::test {

struct GrowthInput {
  Mesh mesh;
  std::vector<Vec3d> sites{};  ///< explicit sites; if empty, the pattern `uniform` is used
  std::uint32_t uniform = 0;   ///< sites of the pattern `uniform`
};

struct GrowthFamily {
  const char* name;
  const char* grows;                   ///< unit of its size
  std::array<std::uint32_t, 4> sizes;  ///< for the benchmark: each is two or three times the one before
  GrowthInput (*make)(std::uint32_t size, std::uint64_t seed);
};

/// All families, in a fixed order.
const std::vector<GrowthFamily>& growth_families();
/// Null if there is no family with this name.
const GrowthFamily* find_growth_family(const std::string& name);

/// The prism from z = 0 to z = 1 over a closed polygon of at least three points. The polygon is
/// counter-clockwise if it does not cross itself. The lids are fans. The prism is closed and consistently
/// oriented for any polygon.
Mesh prism_over(const std::vector<Vec2d>& polygon);
/// The parallelepiped with this corner and these edges, which form a right-handed triple: 12 triangles.
Mesh parallelepiped(const Vec3d& corner, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace fracture::test
