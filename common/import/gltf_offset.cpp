#include "common/import/gltf_offset.hpp"

#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "common/base/words.hpp"
#include "common/import/file_positions.hpp"
#include "common/import/gltf_accessor.hpp"
#include "common/import/gltf_skin.hpp"
#include "common/import/refused.hpp"

namespace fracture {
namespace {

bool is_finite(const Vec3d& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

/// The bounds that the accessor states. If they are missing, or say nothing about the values, those of its values.
Box box_of_accessor(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = at(model.accessors, index, "accessor");
  const std::vector<double>&low = accessor.minValues, &high = accessor.maxValues;
  Box box;
  if (!accessor.normalized && !accessor.sparse.isSparse && low.size() == 3 && high.size() == 3) {
    const Vec3d min{low[0], low[1], low[2]}, max{high[0], high[1], high[2]};
    if (is_finite(min) && is_finite(max) && min.x <= max.x && min.y <= max.y && min.z <= max.z)
      return {min, max};
  }
  const std::vector<double> values = read_accessor(model, index, 3);
  for (std::size_t k = 0; k + 2 < values.size(); k += 3)
    if (const Vec3d p{values[k], values[k + 1], values[k + 2]}; is_finite(p)) box.add(p);
  return box;
}

Vec3d corner(const Box& box, int which) {
  return {(which & 1 ? box.max : box.min).x, (which & 2 ? box.max : box.min).y,
          (which & 4 ? box.max : box.min).z};
}

void add_moved(const Box& box, const Transform& by, Box& to) {
  if (box.empty()) return;
  for (int which = 0; which < 8; ++which)
    if (const Vec3d p = by.point(corner(box, which)); is_finite(p)) to.add(p);
}

/// The boxes of all primitives with triangles.
class MeshBoxes {
 public:
  explicit MeshBoxes(const tinygltf::Model& model) : model_(model) {}

  const Box& of(int mesh) {
    const auto [it, fresh] = boxes_.try_emplace(mesh);
    if (fresh)
      for (const tinygltf::Primitive& primitive : at(model_.meshes, mesh, "mesh").primitives) {
        const auto position = primitive.attributes.find("POSITION");
        if (primitive.mode < TINYGLTF_MODE_TRIANGLES || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN ||
            position == primitive.attributes.end())
          continue;
        it->second.add(box_of_accessor(model_, position->second));
      }
    return it->second;
  }

 private:
  const tinygltf::Model& model_;
  std::map<int, Box> boxes_;
};

}  // namespace

Vec3d gltf_offset(const tinygltf::Model& model, const GltfScene& scene, std::uint64_t max_instances) {
  constexpr std::size_t kMostMoved = 10'000'000;  // boxes; many nodes can name the same long list
  MeshBoxes boxes(model);
  std::map<int, std::vector<Transform>> joints_of;  // by the skin
  std::size_t moved = 0;
  const auto count = [&](std::size_t more, const char* what) {
    moved += more;
    if (moved > kMostMoved)
      refuse(ErrorCode::kTooLarge, "The nodes of the glTF have more than " + grouped(kMostMoved) + " " +
                                       what +
                                       " in total. Reduce the scene, or divide it into several files.");
  };
  Box all;
  for (const int index : scene.order) {
    const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(index)];
    if (node.mesh < 0) continue;
    const Box& box = boxes.of(node.mesh);
    if (node.skin >= 0) {
      const auto [joints, fresh] = joints_of.try_emplace(node.skin);
      if (fresh) joints->second = joint_matrices(model, scene, at(model.skins, node.skin, "skin"), {});
      count(joints->second.size(), "joints");
      for (const Transform& joint : joints->second) add_moved(box, joint, all);
      continue;
    }
    const Transform& world = *scene.world[static_cast<std::size_t>(index)];
    const std::vector<Transform> instances = gltf_instances(model, node, max_instances);
    count(instances.size(), "instances");
    for (const Transform& instance : instances)
      add_moved(box, instance == Transform{} ? world : world * instance, all);
  }
  return offset_for(all);
}

void subtract(const Vec3d& offset, GltfScene& scene) {
  if (offset == Vec3d{}) return;
  for (auto& world : scene.world)
    if (world) world->t = world->t - offset;
}

}  // namespace fracture
