// Welding: turns wedges of the file into vertices of the surface. First by exact position (glTF splits a
// vertex at every seam). Then within a tolerance, but only if that closes open edges (STL and CAD exports
// that differ in the last bits).
#pragma once

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Returns the surface of the mesh's triangles over distinct positions, numbered in the order in which the
/// triangles use them, with all half-edges open. -0 counts as +0 (and becomes +0); every other bit is kept.
/// Triangles with two corners at the same position are dropped. This opens nothing, because one of their
/// edges vanishes and the other two are opposite. A triangle with three distinct corners on a line is kept,
/// because its neighbours need its edges. Errors: kEmptyMesh, kNotFinite (with the vertex), kMalformedMesh
/// (an index beyond the positions), kTooLarge (2^30 or more positions).
Expected<Surface> weld_exact(const Mesh& mesh, SolidReport& report, const Execution& execution);

/// Merges vertices of open edges that are nearer than `tolerance` (metres; chains of such pairs merge as one)
/// into the vertex with the lowest id. Merges only clusters that make two open edges coincide;
/// weld_ends_of_seams() merges others. Returns true if something was merged; then triangles that became
/// degenerate are dropped, and the edge table is out of date.
bool weld_tolerant(Surface& surface, const EdgeTable& edges, double tolerance, SolidReport& report,
                   const Execution& execution);

/// Relative to the size: the farthest that the two sides of a crack may be from each other.
inline constexpr double kWidestCrack = 1e-3;

/// Offers the least weld tolerance that joins open edges which are nearer than kWidestCrack times the `diagonal` (m) of the
/// surface's box, if it is larger than `tolerance` (as a share of the diagonal). Tolerances have one digit: 1, 2 or 5.
/// Nothing is merged here. `edges` must be up to date.
void offer_welding(const Surface& surface, const EdgeTable& edges, double diagonal, double tolerance,
                   SolidReport& report, const Execution& execution);

}  // namespace fracture::solid_detail
