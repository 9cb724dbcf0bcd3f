// Turns a piece into a fragment: vertices with attributes, triangles sorted by material, mass properties
// and final rounded positions.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Returns the fragment of a piece. Exterior vertices have the source's attributes: unchanged at input
/// vertices, interpolated linearly along edges and across triangles at cut points. Cap vertices have the
/// cap's normal, planar UVs in metres and the colour white. Also fills the fields that prove the result,
/// but not `id`. Throws Interrupted.
Fragment assemble(const RestrictedDiagram& diagram, const Ownership& ownership, const Piece& piece,
                  Pivot pivot, const Execution& execution = kUninterrupted);

}  // namespace fracture
