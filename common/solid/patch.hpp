// Some triangles of a solid as a surface of their own, for those who look at one place of it. Everything keeps its
// order, so that what is exact comes out as it does from the whole, to the bit. It is not closed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct SolidPatch {
  /// With the source and the box of the whole; no shells, no report.
  Solid solid;
  std::vector<VertexId> vertices;        ///< per vertex: its number in the whole, ascending
  std::vector<std::uint32_t> triangles;  ///< per triangle
  std::vector<std::uint32_t> parts;      ///< per part

  /// The number in the patch; the part must be there.
  std::uint32_t local_part(std::uint32_t part) const;
};

/// `triangles`: ascending, none twice. `further_parts`: parts that it shall have, whether or not they have a triangle
/// here; in any order. n log n in what comes out. Throws Interrupted.
SolidPatch patch_of(const Solid& whole, std::vector<std::uint32_t> triangles,
                    std::span<const std::uint32_t> further_parts, const Execution& execution);

}  // namespace fracture
