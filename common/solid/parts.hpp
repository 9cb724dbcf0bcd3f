// From shells to parts, and the order in which a Solid has its triangles.
#pragma once

#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/nesting.hpp"
#include "common/solid/shells.hpp"
#include "common/solid/solid.hpp"
#include "common/solid/surface.hpp"

namespace fracture::solid_detail {

/// Shells become parts with cavities; Part::shells are ids of `shells`. Cavities that outweigh their shell
/// (possible only where shells cross) stand for themselves. Returns the part of each shell, kNoIndex for flat
/// ones, which are dropped.
std::vector<std::uint32_t> make_parts(const Shells& shells, Nesting& nesting, const Mesh& mesh,
                                      const Surface& surface, std::vector<Part>& parts,
                                      const Execution& execution);

/// Turns the triangles of shells that are inside out.
void turn_shells(Surface& surface, const Shells& shells, const std::vector<std::uint8_t>& reversed,
                 const Execution& execution);

/// Triangles in their final order: by part, then as they were; dropped shells are left out.
void group_by_part(Surface& surface, Shells& shells, const std::vector<std::uint32_t>& part_of_shell,
                   std::size_t parts, const Execution& execution);

void drop_unused_vertices(Surface& surface, const Execution& execution);

/// The ordered surface, whose arrays it takes, with the ids every later stage uses. Edges are numbered in the
/// order the triangles meet them. `new_shell`: per shell, its number in the solid.
void write_out(const Mesh& mesh, Surface& surface, Shells& shells,
               const std::vector<std::uint32_t>& part_of_shell, const std::vector<std::uint32_t>& new_shell,
               Solid& solid, const Execution& execution);

}  // namespace fracture::solid_detail
