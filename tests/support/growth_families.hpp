// Families of meshes and sites that come in any size: what grows is chosen so that what goes in and what
// comes out grow in proportion to it, while something between the two (pairs of parts, regions of a cap,
// neighbours of a cell, crossings of a loop) could grow faster. bench_growth measures them, fuzz_fracture
// takes them in small.
//
// Basic arithmetic and square roots only: the same input everywhere, for a seed.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace fracture::test {

struct GrowthInput {
  Mesh mesh;
  std::vector<Vec3d> sites{};  ///< where they are; empty: `uniform` sites
  std::uint32_t uniform = 0;   ///< sites of the pattern `uniform`
};

struct GrowthFamily {
  const char* name;
  const char* grows;                   ///< what its size counts
  std::array<std::uint32_t, 4> sizes;  ///< for the benchmark: each about twice or thrice the one before
  GrowthInput (*make)(std::uint32_t size, std::uint64_t seed);
};

/// All of them, in a fixed order.
const std::vector<GrowthFamily>& growth_families();
/// Null when there is none of this name.
const GrowthFamily* find_growth_family(const std::string& name);

/// The prism from z = 0 to z = 1 over a closed polygon of at least three points, counter-clockwise where it
/// does not cross itself; its lids are fans. Closed and consistently oriented whatever the polygon does.
Mesh prism_over(const std::vector<Vec2d>& polygon);
/// The parallelepiped with this corner and these edges, which make a right-handed triple: 12 triangles.
Mesh parallelepiped(const Vec3d& corner, const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace fracture::test
