#include "common/import/gltf_morph.hpp"

#include "common/import/gltf_accessor.hpp"

namespace fracture {

std::vector<MorphTarget> active_targets(const tinygltf::Primitive& primitive, const tinygltf::Mesh& mesh,
                                        const tinygltf::Node& node) {
  const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
  std::vector<MorphTarget> targets;
  for (std::size_t k = 0; k < primitive.targets.size() && k < weights.size(); ++k)
    if (weights[k] != 0) targets.push_back({weights[k], primitive.targets[k]});
  return targets;
}

bool add_displacements(const tinygltf::Model& model, const std::vector<MorphTarget>& targets,
                       const std::string& attribute, std::size_t stride, std::vector<double>& values,
                       Remarks& remarks) {
  bool added = false;
  if (values.empty()) return added;
  const std::size_t count = values.size() / stride;
  for (const MorphTarget& target : targets) {
    const auto accessor = target.accessors.find(attribute);
    if (accessor == target.accessors.end()) continue;
    const int width = accessor_width(model, accessor->second);
    const auto components = static_cast<std::size_t>(width > 0 ? width : 0);
    const std::vector<double> moves =
        components == 0 ? std::vector<double>() : read_accessor(model, accessor->second, width);
    if (components == 0 || components > stride || moves.size() != count * components) {
      remarks.warn(
          "A morph target was not applied, because it and its mesh have different numbers of vertices. The fragments "
          "have the shape without this target. Export the file again without compression.");
      continue;
    }
    for (std::size_t v = 0; v < count; ++v)
      for (std::size_t c = 0; c < components; ++c)
        values[stride * v + c] += target.weight * moves[components * v + c];
    added = true;
  }
  return added;
}

}  // namespace fracture
