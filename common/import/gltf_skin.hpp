// Skins of a glTF: moves the vertices of a skinned mesh to the pose that the file stores.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/import/gltf_model.hpp"
#include "common/import/transform.hpp"

namespace fracture {

/// One matrix per joint, which moves the mesh to the pose stored in the file (joint's world · inverse bind
/// matrix). `offset`: what was subtracted from the scene. Throws Refused.
std::vector<Transform> joint_matrices(const tinygltf::Model& model, const GltfScene& scene,
                                      const tinygltf::Skin& skin, const Vec3d& offset);

/// Moves the vertices of a skinned mesh to the world. If the stored pose is the bind pose, all joints agree
/// up to the rounding of the inverse bind matrices. Then one matrix moves the whole mesh, and identical
/// vertices stay identical.
class Skinning {
 public:
  /// `size`: largest coordinate of the mesh. `offset`: what was subtracted from the scene.
  Skinning(std::vector<Transform> joints, double size, const Vec3d& offset);

  const std::optional<Transform>& rigid() const { return rigid_; }

  /// The weighted mean of the joints' matrices. `joints` and `weights`: four values per vertex in each set. Throws
  /// Refused if a vertex refers to a joint that does not exist.
  Transform blend(const std::vector<std::vector<double>>& joints,
                  const std::vector<std::vector<double>>& weights, std::size_t vertex) const;

 private:
  std::vector<Transform> joints_;
  Transform unmoved_;  ///< for vertices that no joint moves; subtracts only the offset
  std::optional<Transform> rigid_;
};

}  // namespace fracture
