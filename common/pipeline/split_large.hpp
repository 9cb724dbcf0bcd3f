// Fragments that are too large get further sites: the source paper's volume filter turned round.
#pragma once

#include <cstdint>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/solid/image.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct Diagram;
struct FractureParameters;

/// What asking for a largest volume came to.
struct SplitFigures {
  std::uint32_t sites_added = 0, passes = 0;
  std::uint32_t too_large = 0;  ///< pieces above the volume when the passes or the sites ran out
  bool operator==(const SplitFigures&) const = default;
};

/// How often the cells are measured and divided again.
inline constexpr std::uint32_t kMaxSplitPasses = 16;

/// Adds sites to the diagram until no cell's piece of the solid is larger than the parameters' max_volume (m³, > 0), or
/// there are most_sites of them, with those that the hits will make: in each pass every cell with a larger piece gets
/// as many further sites as it holds that volume, from a sequence of uniform points of the solid. Deterministic in the
/// seed. One clipping of the surface a pass. `solid` is seen through the diagram's map; the diagram must have no groups.
Expected<SplitFigures> split_large(const SeenSolid& solid, Diagram& diagram,
                                   const FractureParameters& parameters, const Execution& execution);

}  // namespace fracture
