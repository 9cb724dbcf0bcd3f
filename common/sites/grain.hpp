// Direction of the grain in each part of a solid: its longest axis of inertia.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/sites/pattern.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct Grains {
  /// Unit vectors, at most `most`, each at least about ten degrees from the others
  std::vector<Vec3d> directions;
  std::vector<std::uint8_t> of_part;  ///< index into directions
};

/// Computes the grain. `of` = kNode: the parts of one node share one direction, computed from all of them
/// together. kMaterial: parts share a direction if the same material covers most of their surface; each
/// part's moments are taken about its own middle. `whole` is the direction of anything less than 1.5 times as
/// long as wide. If there are more than `most` directions, the smallest parts use the nearest of the others.
/// Throws Interrupted.
Grains grains_of(const Solid& solid, GrainOf of, const Vec3d& whole, std::size_t most,
                 const Execution& execution = {});

}  // namespace fracture
