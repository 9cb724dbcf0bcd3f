#include "common/import/mesh_builder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "common/base/gathered.hpp"
#include "common/base/printable.hpp"
#include "common/base/words.hpp"
#include "common/import/limit_words.hpp"
#include "common/mesh/copied_limits.hpp"
#include "common/mesh/material_library.hpp"

namespace fracture {
namespace {

bool finite(const Vec3f& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

/// Attributes affect only the appearance. So a value that is not a number is replaced by a neutral one, and
/// the mesh is not refused.
template <class Vec>
bool neutralise(Vec& value, const Vec& neutral) {
  const auto* f = reinterpret_cast<const float*>(&value);
  for (std::size_t k = 0; k < sizeof(Vec) / sizeof(float); ++k)
    if (!std::isfinite(f[k])) {
      value = neutral;
      return true;
    }
  return false;
}

template <class Vec>
std::uint64_t neutralise(std::vector<Vec>& values, const Vec& neutral) {
  std::uint64_t changed = 0;
  for (Vec& value : values) changed += neutralise(value, neutral);
  return changed;
}

template <class T>
void append(std::vector<T>& to, std::size_t before, std::vector<T>&& from, std::size_t count, const T& fill) {
  if (from.empty()) {
    if (!to.empty()) to.resize(before + count, fill);
    return;
  }
  to.resize(before, fill);
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

std::uint32_t MeshBuilder::add_group(std::string name, std::uint32_t parent) {
  if (name.empty()) return parent;
  mesh_.groups.push_back({std::move(name), parent});
  return static_cast<std::uint32_t>(mesh_.groups.size() - 1);
}

std::uint32_t MeshBuilder::add_source_node(std::string name, std::uint32_t parent, std::string extras) {
  const std::uint32_t level = parent == kNoIndex ? 1 : level_[parent] + 1;
  if (name.empty() || level > kMostSourceLevels) return parent;
  name = node_name_within_limit(std::move(name));
  bytes_ += name.size() + extras.size();  // add() checks the sum
  tree_.nodes.push_back({std::move(name), parent, std::move(extras)});
  level_.push_back(level);
  return static_cast<std::uint32_t>(tree_.nodes.size() - 1);
}

void MeshBuilder::begin_node(std::string name, std::uint32_t group, const MeshInstance& instance) {
  mesh_.node_names.push_back(std::move(name));
  mesh_.group_of_node.push_back(group);
  mesh_.instances.push_back(instance);
}

void MeshBuilder::set_extras(std::string members) {
  if (members.empty()) return;
  bytes_ += members.size();  // each instance of a node has a copy; add() checks the sum
  mesh_.node_extras.resize(mesh_.node_names.size());
  mesh_.node_extras.back() = std::move(members);
}

Expected<void> MeshBuilder::add(Surface surface) {
  const std::size_t before = mesh_.positions.size(), count = surface.positions.size();
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t wedge : triangle)
      if (wedge >= count)
        return fail(ErrorCode::kMalformedMesh,
                    "A triangle of \"" + mesh_.node_names.back() + "\" refers to vertex " +
                        std::to_string(wedge) + "; there are only " + std::to_string(count) + " vertices.");
  const std::uint64_t triangles = mesh_.triangles.size() + surface.triangles.size();
  if (triangles > limits_.max_triangles)
    return fail(ErrorCode::kTooLarge,
                "With \"" + shortened(mesh_.node_names.back()) + "\", the scene has " +
                    counted(triangles, "triangle", "triangles") + "; the limit is " +
                    triangle_limit(limits_.max_triangles) + ". " + kSmallerMesh,
                {}, {{"triangles", triangles}, {"limit", limits_.max_triangles}});
  const Attributes& a = surface.attributes;
  if (a.uvs.size() > kMostAttributeSets || a.colors.size() > kMostAttributeSets)
    return fail(ErrorCode::kTooLarge,
                "A surface of \"" + shortened(mesh_.node_names.back()) + "\" has more than " +
                    std::to_string(kMostAttributeSets) +
                    " sets of texture coordinates or colours, which is the limit. Export it with fewer.",
                {}, {{"limit", kMostAttributeSets}});
  bytes_ += surface.triangles.size() * 20 +
            count * (12 + (a.normals.empty() ? 0 : 12) + (a.tangents.empty() ? 0 : 16) + 8 * a.uvs.size() +
                     16 * a.colors.size());
  if (bytes_ > limits_.max_decoded_bytes || before + count >= kNoIndex)
    return fail(ErrorCode::kTooLarge,
                "With \"" + shortened(mesh_.node_names.back()) + "\", the scene takes " + data_size(bytes_) +
                    " in memory; the limit is " + decoded_limit(limits_.max_decoded_bytes) + ". " +
                    kSmallerMesh,
                {}, {{"limit", limits_.max_decoded_bytes}});

  mesh_.positions.insert(mesh_.positions.end(), surface.positions.begin(), surface.positions.end());
  Attributes& all = mesh_.attributes;
  append(all.normals, before, std::move(surface.attributes.normals), count, Vec3f{});
  append(all.tangents, before, std::move(surface.attributes.tangents), count, Vec4f{});
  all.uvs.resize(std::max(all.uvs.size(), surface.attributes.uvs.size()));
  surface.attributes.uvs.resize(all.uvs.size());
  for (std::size_t set = 0; set < all.uvs.size(); ++set)
    append(all.uvs[set], before, std::move(surface.attributes.uvs[set]), count, Vec2f{});
  all.colors.resize(std::max(all.colors.size(), surface.attributes.colors.size()));
  surface.attributes.colors.resize(all.colors.size());
  for (std::size_t set = 0; set < all.colors.size(); ++set)
    append(all.colors[set], before, std::move(surface.attributes.colors[set]), count, Vec4f{1, 1, 1, 1});

  const auto node = static_cast<std::uint32_t>(mesh_.node_names.size() - 1);
  for (auto triangle : surface.triangles) {
    for (std::uint32_t& wedge : triangle) wedge += static_cast<std::uint32_t>(before);
    mesh_.triangles.push_back(triangle);
  }
  mesh_.material.insert(mesh_.material.end(), surface.materials.begin(), surface.materials.end());
  mesh_.node.resize(mesh_.triangles.size(), node);
  return {};
}

void MeshBuilder::set_library(MaterialLibrary library) {
  mesh_.library = std::make_shared<const MaterialLibrary>(std::move(library));
}

void MeshBuilder::pad_to(std::size_t size) {
  Attributes& a = mesh_.attributes;
  if (!a.normals.empty()) a.normals.resize(size);
  if (!a.tangents.empty()) a.tangents.resize(size);
  for (auto& set : a.uvs) set.resize(size);
  for (auto& set : a.colors) set.resize(size, Vec4f{1, 1, 1, 1});
}

void MeshBuilder::set_tree() {
  if (tree_.nodes.empty() || tree_.of_instance.size() != mesh_.node_names.size()) return;
  std::vector<std::uint32_t> number(tree_.nodes.size(), kNoIndex);
  for (const std::uint32_t node : tree_.of_instance)
    for (std::uint32_t n = node; n != kNoIndex && number[n] == kNoIndex; n = tree_.nodes[n].parent)
      number[n] = 0;
  SourceTree used;
  for (std::size_t k = 0; k < number.size(); ++k) {
    if (number[k] == kNoIndex) continue;
    number[k] = static_cast<std::uint32_t>(used.nodes.size());
    SourceNode& node = used.nodes.emplace_back(std::move(tree_.nodes[k]));
    if (node.parent != kNoIndex) node.parent = number[node.parent];
  }
  bool is_list = used.nodes.size() == tree_.of_instance.size();
  for (const std::uint32_t node : tree_.of_instance) {
    is_list =
        is_list && number[node] == used.of_instance.size() && used.nodes[number[node]].parent == kNoIndex;
    used.of_instance.push_back(number[node]);
  }
  if (!is_list) mesh_.source_tree = std::make_shared<const SourceTree>(std::move(used));
}

Expected<Mesh> MeshBuilder::finish() {
  if (mesh_.triangles.empty())
    return fail(ErrorCode::kEmptyMesh, "The file has no triangles. Export a mesh with faces.");
  if (mesh_.groups.empty()) mesh_.group_of_node.clear();
  set_tree();
  if (!mesh_.node_extras.empty()) mesh_.node_extras.resize(mesh_.node_names.size());
  pad_to(mesh_.positions.size());
  for (std::size_t v = 0; v < mesh_.positions.size(); ++v) {
    if (finite(mesh_.positions[v])) continue;
    // JSON has no NaN, so the vertex is identified by its index and its node.
    std::string node;
    for (std::size_t t = 0; t < mesh_.triangles.size() && node.empty(); ++t)
      for (const std::uint32_t wedge : mesh_.triangles[t])
        if (wedge == v) node = " of \"" + mesh_.node_names[mesh_.node[t]] + "\"";
    return fail(ErrorCode::kNotFinite,
                "Vertex " + std::to_string(v) + node + " has a coordinate that is not a finite number.", {},
                {{"vertex", v}});
  }
  Attributes& a = mesh_.attributes;
  std::uint64_t changed = neutralise(a.normals, Vec3f{}) + neutralise(a.tangents, Vec4f{});
  for (auto& set : a.uvs) changed += neutralise(set, Vec2f{});
  for (auto& set : a.colors) changed += neutralise(set, Vec4f{1, 1, 1, 1});
  if (changed > 0)
    mesh_.remarks.warn(
        counted(
            changed,
            "normal, UV or colour is not a finite number and was replaced by a neutral value. The shading "
            "may be wrong there. Repair it",
            "normals, UVs and colours are not finite numbers and were replaced by neutral values. The "
            "shading may be wrong there. Repair them") +
        " in a modelling tool.");
  return std::move(mesh_);
}

void merge_identical_wedges(Surface& surface) {
  const std::size_t count = surface.positions.size();
  const Attributes& a = surface.attributes;
  // One row of bits per wedge, with open addressing over rows (hash by FNV-1a over words, comparison by
  // memcmp).
  const std::size_t words =
      3 + (a.normals.empty() ? 0 : 3) + (a.tangents.empty() ? 0 : 4) + 2 * a.uvs.size() + 4 * a.colors.size();
  std::vector<std::uint32_t> rows(count * words);
  for (std::size_t v = 0; v < count; ++v) {
    std::uint32_t* row = &rows[v * words];
    const auto put = [&row](const auto& value) {
      std::memcpy(row, &value, sizeof(value));
      row += sizeof(value) / sizeof(std::uint32_t);
    };
    put(surface.positions[v]);
    if (!a.normals.empty()) put(a.normals[v]);
    if (!a.tangents.empty()) put(a.tangents[v]);
    for (const auto& set : a.uvs) put(set[v]);
    for (const auto& set : a.colors) put(set[v]);
  }
  const std::size_t slots = std::bit_ceil(2 * count + 1);
  std::vector<std::uint32_t> table(slots, kNoIndex), first_of(count, kNoIndex), kept;
  const auto find = [&](std::uint32_t v) {
    const std::uint32_t* row = &rows[v * words];
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (std::size_t k = 0; k < words; ++k) hash = (hash ^ row[k]) * 0x100000001b3ull;
    hash ^= hash >> 29;
    for (std::size_t slot = hash & (slots - 1);; slot = (slot + 1) & (slots - 1)) {
      if (table[slot] == kNoIndex) {
        table[slot] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(v);
        return table[slot];
      }
      if (std::memcmp(row, &rows[kept[table[slot]] * words], words * sizeof(std::uint32_t)) == 0)
        return table[slot];
    }
  };
  for (auto& triangle : surface.triangles)
    for (std::uint32_t& wedge : triangle) {
      if (first_of[wedge] == kNoIndex) first_of[wedge] = find(wedge);
      wedge = first_of[wedge];
    }
  const auto gather = [&kept](auto& values) { values = gathered(values, kept); };
  gather(surface.positions);
  gather(surface.attributes.normals);
  gather(surface.attributes.tangents);
  for (auto& set : surface.attributes.uvs) gather(set);
  for (auto& set : surface.attributes.colors) gather(set);
}

}  // namespace fracture
