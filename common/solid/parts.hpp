// Turns shells into parts, and puts the triangles into the order of a Solid.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/nesting.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Turns shells into parts with cavities; Part::shells are ids of `shells`. If cavities have more volume than
/// their shell (possible only if shells cross), they become separate parts. Returns the part of each shell,
/// or kNoIndex for flat shells, which are dropped.
std::vector<std::uint32_t> make_parts(const Shells& shells, Nesting& nesting, const Mesh& mesh,
                                      const Surface& surface, std::vector<Part>& parts,
                                      const Execution& execution);

/// Flips the triangles of shells that are inside out.
void turn_shells(Surface& surface, const Shells& shells, const std::vector<std::uint8_t>& reversed,
                 const Execution& execution);

/// Puts triangles into their final order: by part, then in the previous order. Leaves out dropped shells.
void group_by_part(Surface& surface, Shells& shells, const std::vector<std::uint32_t>& part_of_shell,
                   std::size_t parts, const Execution& execution);

void drop_unused_vertices(Surface& surface, const Execution& execution);

/// Builds the solid, with the ids that every later stage uses, from the ordered surface, whose arrays it
/// takes. Edges are numbered in the order in which the triangles use them. `new_shell`: the number of each
/// shell in the solid.
void write_out(const Mesh& mesh, Surface& surface, Shells& shells,
               const std::vector<std::uint32_t>& part_of_shell, const std::vector<std::uint32_t>& new_shell,
               Solid& solid, const Execution& execution);

}  // namespace fracture::solid_detail
