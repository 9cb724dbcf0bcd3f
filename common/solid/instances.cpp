#include "common/solid/instances.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/solid/solid.hpp"

namespace fracture {
namespace {

/// Relative to the scale: transforms are products of float32 matrices and quaternions.
constexpr double kSimilar = 1e-5;
/// Scales that differ by less are equal: quaternions of float32 are not exactly of unit length.
constexpr double kSameScale = 1e-6;

/// Compares the parts of two nodes, triangle by triangle.
class Comparison {
 public:
  Comparison(const Solid& solid, Pacer& pacer)
      : solid_(solid),
        mesh_(*solid.source),
        pacer_(pacer),
        vertex_(solid.positions.size(), kNoIndex),
        wedge_(mesh_.positions.size(), kNoIndex) {
    first_.assign(solid.parts.size() + 1, 0);
    for (const std::uint32_t part : solid.part) ++first_[part + 1];
    for (std::size_t p = 0; p < solid.parts.size(); ++p) first_[p + 1] += first_[p];
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis)
      reach = std::max({reach, std::fabs(solid.box.min[axis]), std::fabs(solid.box.max[axis])});
    tolerance_ = kInstanceTolerance * reach;
  }

  bool same(const Instance& model, const Instance& other, const Similarity& from_model) {
    if (model.parts.size() != other.parts.size()) return false;
    bool same = true;
    for (std::size_t k = 0; same && k < model.parts.size(); ++k)
      same = same_part(model.parts[k], other.parts[k], from_model);
    for (const VertexId v : seen_vertices_) vertex_[v] = kNoIndex;
    for (const std::uint32_t w : seen_wedges_) wedge_[w] = kNoIndex;
    seen_vertices_.clear();
    seen_wedges_.clear();
    return same;
  }

 private:
  // Triangles are grouped by part.
  bool same_part(std::uint32_t a, std::uint32_t b, const Similarity& from_model) {
    const std::uint32_t count = first_[a + 1] - first_[a];
    if (count != first_[b + 1] - first_[b]) return false;
    for (std::uint32_t k = 0; k < count; ++k) {
      pacer_.step(8);
      const std::uint32_t s = first_[a] + k, t = first_[b] + k;
      if (solid_.material[s] != solid_.material[t]) return false;
      for (std::size_t c = 0; c < 3; ++c)
        if (!same_vertex(solid_.triangles[s][c], solid_.triangles[t][c], from_model) ||
            !same_wedge(solid_.wedges[s][c], solid_.wedges[t][c]))
          return false;
    }
    return true;
  }
  bool same_vertex(VertexId a, VertexId b, const Similarity& from_model) {
    if (vertex_[a] != kNoIndex) return vertex_[a] == b;
    vertex_[a] = b;
    seen_vertices_.push_back(a);
    const Vec3d off = from_model.point(to_double(solid_.positions[a])) - to_double(solid_.positions[b]);
    return length(off) <= tolerance_;
  }
  bool same_wedge(std::uint32_t a, std::uint32_t b) {
    if (a == kNoIndex || b == kNoIndex) return a == b;
    if (wedge_[a] != kNoIndex) return wedge_[a] == b;
    wedge_[a] = b;
    seen_wedges_.push_back(a);
    const auto equal = [&](const auto& sets) {
      return std::all_of(sets.begin(), sets.end(), [&](const auto& set) { return set[a] == set[b]; });
    };
    return equal(mesh_.attributes.uvs) && equal(mesh_.attributes.colors);
  }

  const Solid& solid_;
  const Mesh& mesh_;
  Pacer& pacer_;
  double tolerance_ = 0;              // m
  std::vector<std::uint32_t> first_;  // per part: its first triangle, and the end
  // Per vertex and wedge of the model: that of the other node.
  std::vector<std::uint32_t> vertex_, wedge_;
  std::vector<VertexId> seen_vertices_;
  std::vector<std::uint32_t> seen_wedges_;
};

/// Returns, per part, the only node that its source triangles belong to; kNoIndex if there are several or none.
std::vector<std::uint32_t> nodes_of_parts(const Solid& solid, std::vector<char>& shared, Pacer& pacer) {
  const Mesh& mesh = *solid.source;
  std::vector<std::uint32_t> node_of_wedge(mesh.positions.size(), kNoIndex);
  pacer.each(0, mesh.triangles.size(), [&](std::size_t t) {
    for (const std::uint32_t w : mesh.triangles[t]) node_of_wedge[w] = mesh.node[t];
  });
  constexpr std::uint32_t kNotYet = kNoIndex - 1;
  std::vector<std::uint32_t> node(solid.parts.size(), kNotYet);
  pacer.each(0, solid.triangles.size(), [&](std::size_t t) {
    if (solid.wedges[t][0] == kNoIndex) return;
    const std::uint32_t here = node_of_wedge[solid.wedges[t][0]];
    std::uint32_t& of_part = node[solid.part[t]];
    if (of_part == kNotYet) of_part = here;
    if (of_part == here) return;
    for (const std::uint32_t n : {of_part, here})
      if (n < shared.size()) shared[n] = 1;
    of_part = kNoIndex;
  });
  for (std::uint32_t& n : node)
    if (n == kNotYet) n = kNoIndex;
  return node;
}

}  // namespace

Instances find_instances(const Solid& solid, const Execution& execution) {
  Instances found;
  const Mesh& mesh = *solid.source;
  const std::size_t nodes = mesh.instances.size();
  if (nodes < 2 || mesh.node.size() != mesh.triangles.size() || solid.wedges.size() != solid.triangles.size())
    return found;
  std::map<std::uint32_t, std::vector<std::uint32_t>> nodes_of_mesh;
  for (std::uint32_t n = 0; n < nodes; ++n)
    if (mesh.instances[n].mesh != kNoIndex) nodes_of_mesh[mesh.instances[n].mesh].push_back(n);
  std::erase_if(nodes_of_mesh, [](const auto& entry) { return entry.second.size() < 2; });
  if (nodes_of_mesh.empty()) return found;

  Pacer pacer(execution);
  std::vector<char> shared(nodes, 0);  // whether one of the node's parts has triangles of other nodes
  const std::vector<std::uint32_t> node_of_part = nodes_of_parts(solid, shared, pacer);
  std::vector<Instance> at_node(nodes);
  for (std::uint32_t p = 0; p < node_of_part.size(); ++p) {
    pacer.step();
    if (node_of_part[p] >= nodes) continue;
    at_node[node_of_part[p]].parts.push_back(p);
    at_node[node_of_part[p]].volume += solid.parts[p].volume;
  }
  Comparison comparison(solid, pacer);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> chosen;  // (node, model's node)
  for (const auto& [number, of_mesh] : nodes_of_mesh) {
    std::uint32_t model = kNoIndex;
    std::map<std::uint32_t, Similarity> placed;
    for (const std::uint32_t n : of_mesh) {
      pacer.step(16);
      const MeshInstance& m = mesh.instances[n];
      const std::optional<Similarity> here =
          shared[n] || at_node[n].parts.empty() ? std::nullopt : similarity_of(m.x, m.y, m.z, m.t, kSimilar);
      if (!here) continue;
      placed.emplace(n, *here);
      if (model == kNoIndex || here->scale > (1 + kSameScale) * placed.at(model).scale) model = n;
    }
    if (placed.size() < 2) continue;
    std::vector<std::uint32_t> like_model;
    for (const auto& [n, here] : placed) {
      // from the model's place to the mesh, and from there to this place
      const Similarity& at_model = placed.at(model);
      Similarity from_model{
          product(here.rotation, inverse(at_model.rotation)), here.scale / at_model.scale, {}};
      if (std::fabs(from_model.scale - 1) < kSameScale) from_model.scale = 1;
      from_model.move = here.move - from_model.linear(at_model.move);
      if (n == model) from_model = {};
      if (n != model && !comparison.same(at_node[model], at_node[n], from_model)) continue;
      at_node[n].from_model = from_model;
      like_model.push_back(n);
    }
    if (like_model.size() < 2) continue;
    for (const std::uint32_t n : like_model) chosen.emplace_back(n, model);
  }
  std::sort(chosen.begin(), chosen.end());
  std::map<std::uint32_t, std::uint32_t> shape_of_model;  // by the model's node
  for (const auto& [n, model] : chosen) shape_of_model.try_emplace(model, 0);
  for (auto& [model, shape] : shape_of_model) {
    shape = static_cast<std::uint32_t>(found.models.size());
    found.models.push_back(kNoIndex);
  }
  found.of_part.assign(solid.parts.size(), kNoIndex);
  for (const auto& [n, model] : chosen) {
    const auto index = static_cast<std::uint32_t>(found.all.size());
    Instance& instance = found.all.emplace_back(std::move(at_node[n]));
    instance.node = n;
    instance.shape = shape_of_model.at(model);
    if (n == model) found.models[instance.shape] = index;
    for (const std::uint32_t p : instance.parts) found.of_part[p] = index;
  }
  return found;
}

void keep_instances(Solid& solid, const Execution& execution) {
  Instances found = find_instances(solid, execution);
  solid.instances = found.all.empty() ? nullptr : std::make_shared<const Instances>(std::move(found));
}

}  // namespace fracture
