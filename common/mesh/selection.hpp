// Selects the parts of a scene to fracture.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/execution.hpp"
#include "common/base/pacer.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Entries that select nodes and materials, as in SceneNames (mesh/part_selector.hpp): names, patterns or indices. The name of
/// a node also selects all nodes below it. An empty list selects everything. If both lists are given, a triangle must be in
/// both.
struct PartSelection {
  std::vector<std::string> nodes{}, materials{};
  friend bool operator==(const PartSelection&, const PartSelection&) = default;
};

/// Keeps the selected triangles in the mesh, in order, and moves the others with their wedges to
/// mesh.passed_through (null if everything is selected). Errors: kBadParameter if nothing has the name of an
/// entry (extra.known lists the existing names, nearest first), or if the selection is empty. The mesh is then unchanged. Throws
/// Interrupted, also with the mesh unchanged.
Expected<void> restrict_to(Mesh& mesh, const PartSelection& selection,
                           const Execution& execution = kUninterrupted);

/// Removes all triangles for which `kept` is false, and wedges that no triangle uses any more. The others stay in order.
/// `kept`: one per triangle. Throws Interrupted; the mesh is then unchanged.
void keep_triangles(Mesh& mesh, const std::vector<bool>& kept, Pacer& pacer);

}  // namespace fracture
