// Some triangles of a solid as a separate surface, for code that needs only one region of it. The order of
// everything is kept, so exact computations give the same result as on the whole, bit for bit. The surface is
// not closed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct SolidPatch {
  /// Has the source and the box of the whole, but no shells and no report.
  Solid solid;
  std::vector<VertexId> vertices;        ///< per vertex: number in the whole, ascending
  std::vector<std::uint32_t> triangles;  ///< per triangle: number in the whole
  std::vector<std::uint32_t> parts;      ///< per part: number in the whole

  /// The number of a part in the patch. The patch must contain the part.
  std::uint32_t local_part(std::uint32_t part) const;
};

/// `triangles`: ascending, without duplicates. `further_parts`: parts to include even if they have no
/// triangle here, in any order. n log n in the size of the result. Throws Interrupted.
SolidPatch patch_of(const Solid& whole, std::vector<std::uint32_t> triangles,
                    std::span<const std::uint32_t> further_parts, const Execution& execution);

}  // namespace fracture
