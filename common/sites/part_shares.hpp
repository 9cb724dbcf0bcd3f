// How many pieces each part of a solid gets if impacts decide: parts near an impact get pieces by their
// distance to it, whatever their volumes, because what is hit breaks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/sites/pattern.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct PartShares {
  std::vector<double> near;   ///< per part: its share of the pieces near impacts; they add up to 1
  std::vector<double> share;  ///< per part: its share of all pieces; they add up to 1
  std::uint32_t nearest = 0;  ///< the part with the largest `near`; of equal ones, the first
};

/// Shares for a pattern whose impacts are on the solid (sites/request_places.hpp). A part at the distance d
/// (0 if the impact is inside it) weighs 1 / (1 + (d / s)²), because energy thins out with the square of the
/// distance. Here, s is an eighth of the pattern's radius. Parts beyond the radius weigh nothing. The rest of
/// the pieces (ImpactPattern::share, or a fifth) is shared in proportion to volume. None if the solid has one
/// part, if no part is near an impact, or if the pattern does not break parts separately: then volumes alone
/// decide. Linear in triangles for each impact. Throws Interrupted.
std::optional<PartShares> shares_of_parts(const Solid& solid, const SitePattern& pattern,
                                          const Execution& execution);

}  // namespace fracture
