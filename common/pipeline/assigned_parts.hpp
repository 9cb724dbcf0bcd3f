// Parts that break in another way than the rest of the solid, for objects of several materials.
#pragma once

#include <memory>
#include <vector>

#include "common/mesh/part_selector.hpp"

namespace fracture {

struct FractureParameters;

/// How the parts break that a selector matches. If several selectors match a part, the first one decides.
struct AssignedParts {
  PartSelector selector{};
  /// Only the members that a material sets apply: pattern, lloyd, anisotropy, aggregation, density_from, roughness and
  /// size.min_of_mean. The others are those of the request.
  std::shared_ptr<const FractureParameters> breaks{};
  double density = 1;   ///< as a multiple of the density of the other parts
  double strength = 1;  ///< strength of bonds, as a multiple of that of the other parts
};

}  // namespace fracture
