// Judges the invariants I1, I2 and I3 of the geometry contract on a finished FragmentSet with its own
// methods. Each function returns one sentence for each broken statement, and nothing if all hold. judge.hpp
// turns them into GoogleTest failures, and fuzz_fracture aborts on them. This code never calls the pipeline.
#pragma once

#include <string>
#include <vector>

#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

using Violations = std::vector<std::string>;

/// I1: every edge is balanced, in the fragment's own topology and after welding equal positions. The volume
/// is positive.
Violations closed_violations(const FragmentSet& set);

/// Expected figures of all fragments together.
struct Whole {
  double volume = 0;  ///< m³, of the solid, signed: the sum of the fragments
  double area = 0;    ///< m², of its surface
  /// m³: volumes before rounding are right to 1e-9 of this. For one clean shell it is the volume. If shells
  /// cancel each other (cavities, inverted parts that overlap), it is the sum of their absolute volumes.
  double magnitude = 0;
  /// Filled holes are interior triangles without a mirror image, so pairs are not required.
  bool filled = false;
};

/// I2: volumes add up (before rounding; to the stated bound after it), including pockets of the certificate.
/// Interior triangles cancel in pairs, bit for bit in world space. local + pivot is exact.
Violations partition_violations(const FragmentSet& set, const Whole& whole);

/// I3, for a mesh in which each triangle has its own material with the triangle's number. The exterior
/// triangles of each source triangle lie in its plane and box (within a lattice step) and cover its area.
/// `everything` requires that no part of the surface is missing in the fragments.
Violations outside_violations(const FragmentSet& set, const Mesh& traced, bool everything = true);

}  // namespace fracture::test
