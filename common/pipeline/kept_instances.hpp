// Chooses the instances of a mesh that stay whole. All parts of such an instance become one fragment.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Whether instances may stay whole.
bool may_keep_instances(const Solid& solid, const FractureParameters& parameters);

/// The groups of parts that hold together, and the instances that stay whole.
struct PartGroups {
  std::vector<std::uint32_t>
      of_part;  ///< per part: its group, numbered from 0 in the order of their lowest parts
  std::vector<std::uint32_t>
      whole{};  ///< per part: index into Instances::all, or kNoIndex; empty: none stays whole
};

/// An instance stays whole if its volume is at most about the mean volume of `wanted` fragments, and joining it to other parts does
/// not serve their number. So it touches no other part, or more than `wanted` groups of parts touch nothing.
/// Each such instance is a group of its own; parts of the other groups are in contact, with an area. Linear. Throws Interrupted.
PartGroups group_parts(const Solid& solid, const FractureParameters& parameters, std::uint32_t wanted,
                       const Execution& execution);

}  // namespace fracture
