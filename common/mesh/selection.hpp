// Which parts of a scene are fractured.
#pragma once

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Names or indices of nodes (Mesh::node_names) and of materials (their "name" in the library). A name stands
/// for everything that is called so; an entry that is no name but a number is an index. An empty list selects
/// all; where both lists are given a triangle has to be in both.
struct PartSelection {
  std::vector<std::string> nodes{}, materials{};
  friend bool operator==(const PartSelection&, const PartSelection&) = default;
};

/// Leaves the selected triangles in the mesh, in their order, and moves the others, with their wedges, to
/// mesh.passed_through (null when everything is selected). kBadParameter naming the entry that nothing is
/// called, with the names there are in extra.known, or when the selection is empty; then the mesh is as
/// before.
Expected<void> restrict_to(Mesh& mesh, const PartSelection& selection);

}  // namespace fracture
