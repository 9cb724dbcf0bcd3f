// Chooses the instances of a mesh that stay whole. All parts of such an instance become one fragment.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Number of fragments that the request asks for, without those that hits break off; >= 1.
std::uint32_t wanted_fragments(const FractureParameters& parameters);

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
/// With InstanceUse::kAll, each instance stays whole. Each such instance is a group of its own; parts of the other groups are in contact, with an area. Linear. Throws Interrupted.
PartGroups group_parts(const Solid& solid, const FractureParameters& parameters, std::uint32_t wanted,
                       const Execution& execution);

/// Returns the instances that stay whole and have all their parts among `parts` (ascending), as instances of a solid of these parts;
/// null if there are none. They have no models. `kept`: PartGroups::whole of the whole. Linear. Throws Interrupted.
std::shared_ptr<const Instances> kept_instances_among(const Solid& whole,
                                                      const std::vector<std::uint32_t>& kept,
                                                      const std::vector<std::uint32_t>& parts,
                                                      const Execution& execution);

}  // namespace fracture
