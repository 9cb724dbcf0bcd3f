// The fragments of an answer that are whole instances of a mesh, and the shape that they share.
//
// A shape is that of its largest instance, even if hits broke this instance. So it depends only on the solid, and a hit does not
// change the nodes and hulls of other instances.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/pipeline/fracture.hpp"
#include "common/pipeline/fractured_solid.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Finds the fragments that consist of all parts of an instance and have no cuts, and makes their shapes with the hulls that the
/// parameters ask for. Instances that `assigned` gives different materials share no shape. Finds none with Pivot::kSource, whose
/// fragments have no transforms. A placed vertex is at most kInstanceTolerance from the solid's, plus half a lattice step on each
/// axis. Errors: those of fracture(). Throws Interrupted.
Expected<InstancedBodies> find_instanced_bodies(const std::vector<Fragment>& fragments, const Solid& solid,
                                                const FractureParameters& parameters,
                                                const Execution& execution);

/// Gives these fragments the placed hulls of their shapes, unless they have shared hulls already. Throws Interrupted.
void share_hulls(const InstancedBodies& instances, const std::vector<Fragment>& fragments,
                 CollisionHulls& hulls, const Execution& execution);

/// Removes the fragments whose hulls no longer are those of their shapes, because they were trimmed. They get separate
/// meshes.
void separate_trimmed(InstancedBodies& instances, const CollisionHulls& hulls);

/// Counts the fragments that are left, and their shapes. Returns nothing if none are. `of_fragment`: as in `instances`, which
/// need not have it.
std::optional<InstanceFigures> count_instances(const InstancedBodies& instances,
                                               const std::vector<std::uint32_t>& of_fragment);

/// Removes the fragments that carry sheets, because each carries other pieces of sheets and needs its own mesh. These
/// fragments still use the hulls of the shape.
void separate_carriers(InstancedBodies& instances, const std::vector<Fragment>& fragments);

}  // namespace fracture
