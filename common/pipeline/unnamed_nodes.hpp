// Nodes of the source that no fragment of an answer is named after, and those that would only be groups.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Adds an entry to `dropped` for each node of the source that has triangles but names neither a fragment nor a node that stays
/// whole, although a group may have its name. A fragment has the name of one node, although it may have pieces of several. Nodes whose extras are
/// lost with their names have a second entry. `nodes`: those of all fragments of the answer. `set`: its fragments, or some of them.
/// Throws Interrupted.
void add_unnamed_nodes(const Mesh& source, const std::vector<std::uint32_t>& nodes, const FragmentSet& set,
                       std::vector<Dropped>& dropped, const Execution& execution);

/// For an answer with levels, which has no groups. Adds an entry to `dropped` for each node of the source that has no mesh and is above
/// one with triangles, and one for its extras. Throws Interrupted.
void add_nodes_without_group(const Mesh& source, std::vector<Dropped>& dropped, const Execution& execution);

}  // namespace fracture
