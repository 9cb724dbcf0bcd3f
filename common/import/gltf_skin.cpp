#include "common/import/gltf_skin.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/words.hpp"
#include "common/import/gltf_accessor.hpp"
#include "common/import/refused.hpp"

namespace fracture {
namespace {

double largest_difference(const Transform& a, const Transform& b) {
  double d = 0;
  for (const auto& [u, v] : {std::pair{a.x, b.x}, {a.y, b.y}, {a.z, b.z}, {a.t, b.t}})
    for (int k = 0; k < 3; ++k) d = std::max(d, std::abs(u[k] - v[k]));
  return d;
}

/// The matrix of a vertex that no joint moves: it subtracts only the offset.
Transform moved_by(const Vec3d& offset) {
  Transform transform;
  transform.t = transform.t - offset;
  return transform;
}

}  // namespace

std::vector<Transform> joint_matrices(const tinygltf::Model& model, const GltfScene& scene,
                                      const tinygltf::Skin& skin, const Vec3d& offset) {
  std::vector<double> inverse;
  if (skin.inverseBindMatrices >= 0) inverse = read_accessor(model, skin.inverseBindMatrices, 16);
  std::vector<Transform> result;
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    at(model.nodes, skin.joints[j], "joint");
    const auto& world = scene.world[static_cast<std::size_t>(skin.joints[j])];
    Transform bind;
    if (inverse.size() >= 16 * (j + 1)) {
      const double* m = &inverse[16 * j];
      bind = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
    }
    result.push_back(world.value_or(moved_by(offset)) * bind);
  }
  return result;
}

Skinning::Skinning(std::vector<Transform> joints, double size, const Vec3d& offset)
    : joints_(std::move(joints)), unmoved_(moved_by(offset)) {
  constexpr double kRounding = 1e-4;  // float32 matrices multiplied along a chain of some twenty joints
  if (joints_.empty()) return;
  for (const Transform& joint : joints_)
    if (!(largest_difference(joint, joints_[0]) <= kRounding * std::max(1.0, size))) return;
  rigid_ = joints_[0];
  if (largest_difference(*rigid_, unmoved_) <= kRounding * std::max(1.0, size)) rigid_ = unmoved_;
}

Transform Skinning::blend(const std::vector<std::vector<double>>& joints,
                          const std::vector<std::vector<double>>& weights, std::size_t vertex) const {
  Transform sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  double total = 0;
  for (std::size_t set = 0; set < joints.size(); ++set)
    for (std::size_t k = 0; k < 4; ++k) {
      const double weight = weights[set][4 * vertex + k], joint = joints[set][4 * vertex + k];
      if (!(weight > 0)) continue;
      if (!(joint >= 0 && joint < static_cast<double>(joints_.size())))  // may be a float in the file
        refuse(ErrorCode::kMalformedMesh, "A vertex refers to joint " + short_number(joint) +
                                              "; the skin has only " + std::to_string(joints_.size()) +
                                              " joints, counted from 0.");
      const Transform& m = joints_[static_cast<std::size_t>(joint)];
      sum = {sum.x + weight * m.x, sum.y + weight * m.y, sum.z + weight * m.z, sum.t + weight * m.t};
      total += weight;
    }
  if (!(total > 0)) return unmoved_;
  const double scale = 1 / total;
  return {scale * sum.x, scale * sum.y, scale * sum.z, scale * sum.t};
}

}  // namespace fracture
