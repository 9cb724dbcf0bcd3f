// Bonds between parts that the mesh only puts together.
#pragma once

#include <cstddef>

#include "client/world/fragments.hpp"

namespace fracture::world {

/// A file often has its parts as closed surfaces of their own that overlap or touch: eyes in a head, legs at a table.
/// The service bonds fragments of one part, and of parts in contact (`contact_gap`). Parts without such a bond would fall off
/// at the swap. We bond those of their fragments whose hulls touch, with the median strength for each square metre of the
/// answer's bonds. If the answer has no bonds, nothing is added. The area of a bond is half that of the largest face of the box in which the two
/// fragments' boxes overlap. Returns how many bonds it added.
std::size_t bond_touching_parts(FragmentSet& set);

}  // namespace fracture::world
