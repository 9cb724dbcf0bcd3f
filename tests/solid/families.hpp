// Families of growing meshes. Each was quadratic in some stage of make_solid(), or computed for a long time
// without a poll.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/solid/solid.hpp"

namespace fracture::test {

struct GrowingFamily {
  std::string name;
  std::function<Mesh(int size)> mesh;  ///< with about a constant times `size` triangles
  int size;                            ///< the size with about 200,000 triangles or vertices
  SolidOptions options{};
  friend void PrintTo(const GrowingFamily& family, std::ostream* out) { *out << family.name; }
};

std::vector<GrowingFamily> growing_families();

/// A sheet of 2 n² triangles with a corner folded over. Its vertex normal is zero, so it cannot become a
/// slab.
Mesh sheet_with_a_folded_corner(int n);

}  // namespace fracture::test
