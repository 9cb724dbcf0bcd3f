// Chooses the instances of a mesh that stay whole. All parts of such an instance become one fragment.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct PartSet;  // part_sets.hpp

/// Number of fragments that the request asks for, without those that hits break off; >= 1.
std::uint32_t wanted_fragments(const FractureParameters& parameters);

/// Whether instances may stay whole.
bool may_keep_instances(const Solid& solid, const FractureParameters& parameters);

/// The groups of parts that hold together, and the instances that stay whole.
struct PartGroups {
  /// Per part: its group, numbered from 0 in the order of their lowest parts
  std::vector<std::uint32_t> of_part;
  /// Per part: index into Instances::all, or kNoIndex; empty: none stays whole
  std::vector<std::uint32_t> whole{};
};

/// An instance stays whole if its volume is at most about the mean volume of `wanted` fragments, and joining it to other parts does
/// not serve their number. So it touches no other part, or more than `wanted` groups of parts touch nothing. With
/// Parts::kInstances, nothing is joined, so only the volume decides. With InstanceUse::kAll, each instance stays whole. Each such
/// instance is a separate group. With Parts::kTogether, parts of the other groups are in contact, with an area; otherwise each
/// part is a group. Linear. Throws Interrupted.
PartGroups group_parts(const Solid& solid, const FractureParameters& parameters, std::uint32_t wanted,
                       const Execution& execution);

/// Keeps the instances of each set that stay whole as instances of the set's own solid (InstanceUse::kAll). They have no models.
/// The whole decides which ones these are, so that a set of many small ones does not. Linear for each set. Throws Interrupted.
void keep_instances_in(std::vector<PartSet>& sets, const Solid& whole, const FractureParameters& parameters,
                       const Execution& execution);

}  // namespace fracture
