// Selects the parts of a scene to fracture.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Names or indices of nodes (Mesh::node_names) and of materials (their "name" in the library). A name
/// selects everything with that name. An entry that is not a name but a number is an index. An empty list
/// selects everything. If both lists are given, a triangle must be in both.
struct PartSelection {
  std::vector<std::string> nodes{}, materials{};
  friend bool operator==(const PartSelection&, const PartSelection&) = default;
};

/// Keeps the selected triangles in the mesh, in order, and moves the others with their wedges to
/// mesh.passed_through (null if everything is selected). Errors: kBadParameter if nothing has the name of an
/// entry (extra.known lists the existing names), or if the selection is empty. The mesh is then unchanged.
Expected<void> restrict_to(Mesh& mesh, const PartSelection& selection);

}  // namespace fracture
