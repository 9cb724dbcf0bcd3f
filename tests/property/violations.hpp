// The invariants I1, I2 and I3 of the geometry contract, judged on a finished FragmentSet by means of its
// own: each function returns one sentence for each broken statement, and nothing where all hold. judge.hpp
// makes GoogleTest failures of them, fuzz_fracture aborts on them. Nothing here calls the pipeline.
#pragma once

#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

using Violations = std::vector<std::string>;

/// I1: every edge balanced in the fragment's own topology and after welding equal positions; volume positive.
Violations closed_violations(const FragmentSet& set);

/// What the fragments together should be.
struct Whole {
  double volume = 0;  ///< m³, of the solid, signed: what the fragments add up to
  double area = 0;    ///< m², of its surface
  /// m³: volumes before rounding are right to 1e-9 of this. For one clean shell its volume; where shells
  /// cancel each other (cavities, parts that overlap inside out) the sum of their absolute volumes.
  double magnitude = 0;
  /// Filled holes are interior triangles without a mirror image: pairs are not asked for.
  bool filled = false;
};

/// I2: volumes add up (before rounding; the stated bound after it), pockets of the certificate included;
/// interior triangles cancel in pairs, bit for bit in world space; local + pivot is exact.
Violations partition_violations(const FragmentSet& set, const Whole& whole);

/// I3, for a mesh of whose triangles each has a material of its own, with the number of the triangle: the
/// exterior triangles of each source triangle lie in its plane and box (within a lattice step) and cover its
/// area. `everything`: no part of the surface is left out of the fragments.
Violations outside_violations(const FragmentSet& set, const Mesh& traced, bool everything = true);

}  // namespace fracture::test
