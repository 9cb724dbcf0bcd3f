// A piece becomes a fragment: vertices with attributes, triangles by material, figures, final rounded
// positions.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"

namespace fracture {

/// Exterior vertices carry the source's attributes: unchanged at input vertices, interpolated linearly along
/// edges and across triangles at cut points. Cap vertices carry the cap's flat normal, planar UVs in metres,
/// white. Sets what proves the answer, but not `id`. Throws Interrupted.
Fragment assemble(const RestrictedDiagram& diagram, const Ownership& ownership, const Piece& piece,
                  Pivot pivot, const Execution& execution = kUninterrupted);

}  // namespace fracture
