// Collision geometry that the source has for one of its nodes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture {

struct GivenHull {
  std::string name;  ///< of its node in the source, UTF-8
  /// Ascending indices into Mesh::node_names: the nodes that it belongs to, at least one.
  std::shared_ptr<const std::vector<std::uint32_t>> owners;
  /// Whether the convex hull of its points collides (UCX_, -convcol). Otherwise, the surface itself does (-col).
  bool convex = true;
  std::vector<Vec3f> points;                            ///< each position once, in the frame of the mesh
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into points
};

}  // namespace fracture
