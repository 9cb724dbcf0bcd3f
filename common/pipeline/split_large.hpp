// Adds sites to fragments that are too large: the source paper's volume filter, reversed.
#pragma once

#include <cstdint>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/solid/image.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct Diagram;
struct FractureParameters;

/// Effect of max_volume.
struct SplitFigures {
  std::uint32_t sites_added = 0, passes = 0;
  std::uint32_t too_large = 0;  ///< pieces above the limit when the passes or the sites ran out
  bool operator==(const SplitFigures&) const = default;
};

/// Maximum number of times that the cells are measured and divided again.
inline constexpr std::uint32_t kMaxSplitPasses = 16;

/// Adds sites to the diagram until every cell's pieces of the solid are at most max_volume (m³, > 0), or
/// until there are most_sites. In each pass, every cell with a larger piece gets further sites, about as many
/// as max_volume fits into the piece. The sites come from a sequence of uniform points in the solid.
/// Deterministic in the seed. Clips the surface once per pass.
/// `solid` is seen through the diagram's map; the diagram must have no groups.
Expected<SplitFigures> split_large(const SeenSolid& solid, Diagram& diagram,
                                   const FractureParameters& parameters, const Execution& execution);

}  // namespace fracture
