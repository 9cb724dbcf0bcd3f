// The parts of a scene that are not fractured (Mesh::passed_through), and their contacts with the parts of the solid.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

struct Scenery {
  /// The parts of the solid, followed by those of its scenery. It has only positions, triangles, parts, a box and the
  /// contacts between the two kinds of parts.
  Solid both;
  std::vector<std::uint32_t> node_of_part;  ///< per part of the scenery: index into Mesh::node_names
};

/// Stores Solid::scenery; null if all is fractured, or if the rest encloses no volume. keep_contacts() must be called before;
/// its gap applies here, too. The rest is closed as `options` say, but only for this purpose: the file contains it as it was.
/// Costs make_solid() of the rest, and find_contacts() of both. Throws Interrupted.
void keep_scenery(Solid& solid, const SolidOptions& options, const Execution& execution);

}  // namespace fracture
