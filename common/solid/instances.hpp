// The instances of a mesh among the parts of a solid: nodes of the source that place the same mesh by rotation, uniform scale and
// translation. An answer writes the shape of such instances once (pipeline/instanced_bodies.hpp).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/similarity.hpp"

namespace fracture {

struct Solid;

struct Instance {
  std::uint32_t node = 0;   ///< index into Mesh::node_names
  std::uint32_t shape = 0;  ///< index into Instances::models
  /// Indices into Solid::parts, ascending: all parts of the node, and only these
  std::vector<std::uint32_t> parts;
  double volume = 0;      ///< m³
  Similarity from_model;  ///< places the model's parts here; the identity for the model itself
};

struct Instances {
  std::vector<Instance> all;           ///< ascending by node
  std::vector<std::uint32_t> of_part;  ///< per part: index into `all`, or kNoIndex
  /// Per shape: its largest instance (index into `all`; ties: the lowest node)
  std::vector<std::uint32_t> models{};
};

/// How far vertices of an instance may be from those of its model, as a fraction of the solid's largest coordinate. The importer
/// rounds the vertices of each to floats, which moves them by 2^-25 of this coordinate or less on each axis.
inline constexpr double kInstanceTolerance = 0x1p-20;

/// Finds the shapes that have at least two instances. An instance is a node whose parts have the same triangles, materials, UVs
/// and colours as those of its model, and vertices within the tolerance. Nodes that share a part with another node, mirror the
/// mesh or scale its axes differently do not count. Linear. Throws Interrupted.
Instances find_instances(const Solid& solid, const Execution& execution);

/// Sets Solid::instances to the result of find_instances(), or to null if it is empty. Throws Interrupted.
void keep_instances(Solid& solid, const Execution& execution);

}  // namespace fracture
