// Collects surfaces into one Mesh. If a surface lacks an attribute that another surface has, it gets zeros
// (ones for colours). So every attribute array of the Mesh is either empty or complete.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/remarks.hpp"
#include "common/import/import.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/source_tree.hpp"

namespace fracture {

/// Triangles that share one set of wedges, in the frame of the scene's root: one primitive, or several with
/// the same accessors. Attribute arrays are empty or as long as positions.
struct Surface {
  std::vector<Vec3f> positions;
  Attributes attributes;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> materials;  ///< per triangle
};

/// Maximum number of sets of UVs, and of colours. Readers of glTF support far fewer.
inline constexpr std::size_t kMostAttributeSets = 64;

class MeshBuilder {
 public:
  explicit MeshBuilder(const ImportLimits& limits) : limits_(limits) {}

  /// Adds a group of nodes below `parent` (kNoIndex: none), and returns its number. A group without a name is left out; the
  /// result is then `parent`.
  std::uint32_t add_group(std::string name, std::uint32_t parent);
  /// Adds a node of the source below `parent` (kNoIndex: none) to Mesh::source_tree, and returns its number. Nodes must come in the
  /// order of a depth-first walk. A node without a name, or below one of depth kMostSourceLevels, is left out; the result is then
  /// `parent`. `extras`: SourceNode::extras.
  std::uint32_t add_source_node(std::string name, std::uint32_t parent, std::string extras = {});
  /// Sets the node of the mesh instance begun last. If there is a tree, each instance needs one.
  void set_source_node(std::uint32_t node) { tree_.of_instance.push_back(node); }
  /// Begins a mesh instance in a group (kNoIndex: none). The surfaces added next belong to it.
  void begin_node(std::string name, std::uint32_t group = kNoIndex, const MeshInstance& instance = {});
  /// Sets the extras of the mesh instance begun last (Mesh::node_extras).
  void set_extras(std::string members);
  /// Adds a surface. Errors: kMalformedMesh (a triangle uses a vertex that does not exist), kTooLarge.
  Expected<void> add(Surface surface);
  Remarks& remarks() { return mesh_.remarks; }
  std::vector<Dropped>& dropped() { return mesh_.dropped; }
  void set_empty_nodes(std::vector<EmptyNode> nodes) { mesh_.empty_nodes = std::move(nodes); }
  void set_library(MaterialLibrary library);
  void set_copyright(std::string copyright) { mesh_.copyright = std::move(copyright); }

  /// Completes the attribute arrays. Errors: kNotFinite with the first such vertex, kEmptyMesh.
  Expected<Mesh> finish();

 private:
  void pad_to(std::size_t size);
  /// Sets Mesh::source_tree to the nodes above and of mesh instances, unless they are only a list of the instances.
  void set_tree();

  ImportLimits limits_;
  Mesh mesh_;
  SourceTree tree_;
  std::vector<std::uint32_t> level_;  ///< per node of the tree, from 1
  std::uint64_t bytes_ = 0;
};

/// Merges wedges of the surface that are identical in every bit of every attribute. For formats that store
/// one vertex per corner (STL), or that may repeat values (OBJ). Triangles keep their order, and wedges are ordered
/// by first use.
void merge_identical_wedges(Surface& surface);

}  // namespace fracture
