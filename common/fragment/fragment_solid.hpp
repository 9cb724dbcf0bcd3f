// A fragment as a solid, so that it can be cut again in its place.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct FragmentSolid {
  Solid solid;
  std::vector<std::uint32_t> parts;  ///< per part: number in the whole solid; ascending
};

/// Returns the surface of a fragment of `whole`, triangle by triangle, with its attributes. Nothing is welded or
/// repaired: the fragment's topology is already closed. Vertices with several fans of triangles are split.
///
/// `world`: per vertex of the fragment, its position in the frame of the whole. The solid has the box of the whole, so
/// cuts are rounded to the same lattice. Each part has the volume of the whole's largest part, so that cuts are as
/// rough as elsewhere. Triangles of cuts that another fragment has mirrored are marked (Solid::mirrored).
///
/// Degenerate values: a triangle with two equal corners stays. Throws Interrupted, and InternalError if the fragment
/// is open.
FragmentSolid solid_of_fragment(const Fragment& fragment, std::span<const Vec3f> world, const Solid& whole,
                                const Execution& execution);

}  // namespace fracture
