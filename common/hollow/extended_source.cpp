#include "common/hollow/extended_source.hpp"
#include "common/mesh/material_library.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fracture::hollow_detail {
namespace {

/// Copies in blocks with polls in between, because copying a hundred megabytes takes longer than the maximum
/// time between polls.
class Copier {
 public:
  explicit Copier(const Execution& execution) : execution_(execution) {}

  /// Counts the memory before copying.
  template <class T>
  void copy(const std::vector<T>& from, std::size_t more, std::vector<T>& to) const {
    execution_.made(Product::kMeshBytes, (from.size() + more) * sizeof(T));
    constexpr std::size_t kAtOnce = kBytesBetweenPolls / sizeof(T);
    to.reserve(from.size() + more);
    for (std::size_t k = 0; k < from.size(); k += kAtOnce) {
      execution_.poll();
      const auto first = from.begin() + static_cast<std::ptrdiff_t>(k);
      to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(std::min(kAtOnce, from.size() - k)));
    }
  }
  /// Leaves `to` empty if `from` is empty.
  template <class T>
  void copy_any(const std::vector<T>& from, std::size_t more, std::vector<T>& to) const {
    if (!from.empty()) copy(from, more, to);
  }
  template <class T>
  void copy_each(const std::vector<std::vector<T>>& from, std::size_t more,
                 std::vector<std::vector<T>>& to) const {
    for (const auto& set : from) copy(set, more, to.emplace_back());
  }

 private:
  const Execution& execution_;
};

}  // namespace

std::array<Vec3d, 3> corners_of(const InnerSurface& surface, std::size_t triangle) {
  std::array<Vec3d, 3> corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = to_double(surface.positions[surface.triangles[triangle][k]]);
  return corners;
}

ExtendedSource::ExtendedSource(const Mesh& source, std::size_t wedges, std::size_t triangles,
                               const Execution& execution)
    : mesh_(std::make_shared<Mesh>()), pacer_(execution) {
  Mesh& mesh = *mesh_;
  mesh.frame = source.frame;
  mesh.node_names = source.node_names;
  mesh.node_extras = source.node_extras;
  mesh.empty_nodes = source.empty_nodes;
  mesh.groups = source.groups;
  mesh.group_of_node = source.group_of_node;
  mesh.source_tree = source.source_tree;
  mesh.instances = source.instances;
  mesh.library = source.library;
  mesh.given_hulls = source.given_hulls;
  mesh.copyright = source.copyright;
  mesh.passed_through = source.passed_through;
  mesh.remarks = source.remarks;
  mesh.dropped = source.dropped;

  const Copier copier(execution);
  copier.copy(source.positions, wedges, mesh.positions);
  copier.copy_any(source.attributes.normals, wedges, mesh.attributes.normals);
  copier.copy_any(source.attributes.tangents, wedges, mesh.attributes.tangents);
  copier.copy_each(source.attributes.uvs, wedges, mesh.attributes.uvs);
  copier.copy_each(source.attributes.colors, wedges, mesh.attributes.colors);
  copier.copy(source.triangles, triangles, mesh.triangles);
  copier.copy(source.material, triangles, mesh.material);
  copier.copy(source.node, triangles, mesh.node);
  copier.copy_any(source.triangle_color, triangles, mesh.triangle_color);
  // An importer may leave these two empty.
  mesh.material.resize(mesh.triangles.size(), kNoIndex);
  mesh.node.resize(mesh.triangles.size(), 0);
}

std::uint32_t ExtendedSource::add_wedges(const InnerSurface& surface) {
  const auto first = static_cast<std::uint32_t>(mesh_->positions.size());
  std::vector<Vec3d> normals(surface.positions.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    pacer_.step();
    const auto [a, b, c] = corners_of(surface, t);
    for (const std::uint32_t corner : surface.triangles[t])
      normals[corner] = normals[corner] + cross(b - a, c - a);
  }
  mesh_->positions.insert(mesh_->positions.end(), surface.positions.begin(), surface.positions.end());
  Attributes& a = mesh_->attributes;
  // Any direction along the surface is suitable, because no texture is shown there.
  const auto tangent = [](const Vec3d& n) {
    const Vec3d across = std::fabs(n.x) < 0.7 ? cross(n, Vec3d{1, 0, 0}) : cross(n, Vec3d{0, 1, 0});
    return (1 / length(across)) * across;
  };
  for (const Vec3d& sum : normals) {
    pacer_.step(8);
    const double size = length(sum);
    const Vec3d n = size > 0 ? (1 / size) * sum : Vec3d{0, 1, 0};
    if (!a.normals.empty())
      a.normals.push_back({static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
    if (a.tangents.empty()) continue;
    const Vec3d t = tangent(n);
    a.tangents.push_back({static_cast<float>(t.x), static_cast<float>(t.y), static_cast<float>(t.z), 1});
  }
  const std::size_t count = mesh_->positions.size();
  for (auto& set : a.uvs) set.resize(count, {0, 0});
  for (auto& set : a.colors) set.resize(count, {1, 1, 1, 1});
  return first;
}

void ExtendedSource::add_triangle(const std::array<std::uint32_t, 3>& wedges, const Part& part) {
  mesh_->triangles.push_back(wedges);
  mesh_->material.push_back(kCavityMaterial);
  mesh_->node.push_back(part.node);
  if (!mesh_->triangle_color.empty())
    mesh_->triangle_color.push_back(
        {part.color.value_or(LinearColor{}), static_cast<std::uint16_t>(part.color.has_value())});
}

}  // namespace fracture::hollow_detail
