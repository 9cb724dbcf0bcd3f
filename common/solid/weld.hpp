// Welding: wedges of the file become vertices of the surface. First by exact position (glTF splits a vertex
// at every seam), then, only where it closes open edges, within a tolerance (STL and CAD exports that differ
// in the last bits).
#pragma once

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/solid/edges.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// The surface of the mesh's triangles over distinct positions, numbered in the order the triangles use them,
/// with all half-edges open. -0 counts as +0 (and becomes +0); every other bit is kept. Triangles with two
/// corners at one position are dropped: of their edges one vanishes and the other two are opposite, so that
/// dropping them opens nothing. A triangle with three distinct corners on a line stays: its neighbours need
/// its edges. Errors: kEmptyMesh, kNotFinite (with the vertex), kMalformedMesh (an index beyond the
/// positions), kTooLarge (2^30 positions and more).
Expected<Surface> weld_exact(const Mesh& mesh, SolidReport& report, const Execution& execution);

/// Merges vertices of open edges that are nearer than `tolerance` (metres; chains of such pairs merge as one)
/// to the vertex with the lowest id, but only clusters that make two open edges meet. Returns true when
/// something was merged; the triangles that became degenerate are dropped, the edge table is stale.
bool weld_tolerant(Surface& surface, const EdgeTable& edges, double tolerance, SolidReport& report,
                   const Execution& execution);

}  // namespace fracture::solid_detail
