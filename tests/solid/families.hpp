// Families of meshes that grow: each was quadratic in some stage of make_solid(), or long without a poll.
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
  int size;                            ///< at which it has about 200,000 triangles or vertices
  SolidOptions options{};
  friend void PrintTo(const GrowingFamily& family, std::ostream* out) { *out << family.name; }
};

std::vector<GrowingFamily> growing_families();

/// A sheet of 2 n² triangles with a corner folded over, whose vertex normal is zero: it cannot become a slab.
Mesh sheet_with_a_folded_corner(int n);

}  // namespace fracture::test
