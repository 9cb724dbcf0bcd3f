// The invariants I1, I2, I3 and I7 of the geometry contract, judged on a finished FragmentSet by means of its
// own: counting edges, comparing float bits, areas per input triangle, nearest sites by brute force. Nothing
// here calls the pipeline.
#pragma once

#include <span>
#include <string>

#include "common/fragment/fragments.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture::test {

/// Gives every triangle a material of its own, so that exterior triangles of fragments can be traced to their
/// source.
Mesh with_traced_triangles(Mesh mesh);

/// I1: every edge balanced in the fragment's own topology and after welding equal positions; volume positive.
void expect_closed(const FragmentSet& set);

/// I2: volumes add up (1e-9 before rounding; the stated bound after it); interior triangles cancel in pairs,
/// bit for bit in world space; local + pivot is exact.
void expect_partition(const FragmentSet& set, double volume, double area);

/// I3, for a mesh made by with_traced_triangles: the exterior triangles of each source triangle lie in its
/// plane and box (within a lattice step) and cover its area; input vertices are where they were.
void expect_outside_untouched(const FragmentSet& set, const Mesh& traced);

/// No fragment passes through itself: no edge of a triangle pierces the inside of another by more than
/// `tolerance` (m). Near-linear for triangles of even size.
void expect_no_self_crossing(const FragmentSet& set, double tolerance);

/// I7: of `count` points drawn in the box of the mesh, each that lies in the solid lies in one fragment,
/// which has the nearest site among its own; others lie in none. Points too near to a surface for double to
/// tell are not counted.
void expect_voronoi(const FragmentSet& set, const Mesh& mesh, std::span<const Vec3d> sites, int count,
                    std::uint64_t seed);

}  // namespace fracture::test
