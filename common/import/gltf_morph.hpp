// Morph targets at rest: glTF 2.0, 3.7.2.2.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/import/tinygltf_renamed.hpp"

namespace fracture {

/// Targets of a primitive with a weight that is not zero.
struct MorphTarget {
  double weight = 0;
  std::map<std::string, int> accessors;  ///< by attribute
  friend bool operator==(const MorphTarget&, const MorphTarget&) = default;
};

/// The targets that move the primitive at rest. The weights of the node replace those of the mesh; missing ones are zero.
std::vector<MorphTarget> active_targets(const tinygltf::Primitive& primitive, const tinygltf::Mesh& mesh,
                                        const tinygltf::Node& node);

/// Adds weight · displacement of each target to the attribute, in the order of the targets. `values`: `stride` numbers per
/// vertex, of which a target may displace the first ones (for tangents, all but the handedness). A target with another number
/// of vertices is left out with a warning. Returns whether any was added. Throws Refused if an accessor does not exist.
bool add_displacements(const tinygltf::Model& model, const std::vector<MorphTarget>& targets,
                       const std::string& attribute, std::size_t stride, std::vector<double>& values,
                       Remarks& remarks);

}  // namespace fracture
