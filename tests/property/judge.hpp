// Judges the invariants I1, I2, I3 and I7 of the geometry contract on a finished FragmentSet with its own
// methods. It counts edges, compares float bits, adds areas per input triangle, and finds nearest sites by
// brute force. This code never calls the pipeline.
#pragma once

#include <span>
#include <string>

#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// Gives every triangle its own material, so that exterior triangles of fragments can be traced to their
/// source.
Mesh with_traced_triangles(Mesh mesh);

/// I1: every edge is balanced, in the fragment's own topology and after welding equal positions. The volume
/// is positive.
void expect_closed(const FragmentSet& set);

/// I2: volumes add up (to 1e-9 before rounding, to the stated bound after it). Interior triangles cancel in
/// pairs, bit for bit in world space. local + pivot is exact.
void expect_partition(const FragmentSet& set, double volume, double area);

/// I3, for a mesh made by with_traced_triangles. The exterior triangles of each source triangle lie in its
/// plane and box (within a lattice step) and cover its area. Input vertices are where they were.
void expect_outside_untouched(const FragmentSet& set, const Mesh& traced);

/// No fragment passes through itself: no edge of a triangle pierces the inside of another by more than
/// `tolerance` (m). Near-linear for triangles of similar size.
void expect_no_self_crossing(const FragmentSet& set, double tolerance);

/// I7: draws `count` points in the box of the mesh. Each point in the solid must lie in one fragment, and
/// that fragment must have the nearest site among its own. All other points must lie in no fragment. Points
/// too close to a surface for double arithmetic are not counted.
void expect_voronoi(const FragmentSet& set, const Mesh& mesh, std::span<const Vec3d> sites, int count,
                    std::uint64_t seed);

}  // namespace fracture::test
