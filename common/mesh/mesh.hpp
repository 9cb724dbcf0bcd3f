// The mesh that every importer returns and the exporter needs. Triangles refer to *wedges*: a wedge is one
// vertex of the file, a position with one set of attributes (glTF splits a vertex into several wedges along
// seams). Material slots are in source order, and the source's materials, textures and images are unchanged.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/base/id.hpp"
#include "common/base/remarks.hpp"
#include "common/base/vec.hpp"
#include "common/mesh/dropped.hpp"
#include "common/mesh/given_hull.hpp"

namespace fracture {

/// Per-wedge attributes. Each array is empty if no surface of the mesh has the attribute. Otherwise it is as
/// long as Mesh::positions (surfaces without the attribute have zeros, or ones for colours).
struct Attributes {
  std::vector<Vec3f> normals;              ///< unit length
  std::vector<Vec4f> tangents;             ///< xyz unit length, w = +1 or -1 (handedness)
  std::vector<std::vector<Vec2f>> uvs;     ///< uvs[set][wedge]
  std::vector<std::vector<Vec4f>> colors;  ///< colors[set][wedge], linear RGBA
};

/// Linear red, green, blue: 65535 is 1.
using LinearColor = std::array<std::uint16_t, 3>;

/// Mean colour of a piece of surface.
struct SurfaceColor {
  LinearColor light{};
  std::uint16_t known = 0;  ///< 1, or 0 if the colour is unknown
  friend bool operator==(const SurfaceColor&, const SurfaceColor&) = default;
};

struct SourceTree;       // mesh/source_tree.hpp
struct MaterialLibrary;  // mesh/material_library.hpp
/// A library without materials.
std::shared_ptr<const MaterialLibrary> empty_library();

/// The meaning of an imported mesh's coordinates, as far as its file or its format states it.
struct SourceFrame {
  double metres = 1;           ///< metres per unit of the coordinates, > 0
  bool metres_stated = false;  ///< false: not stated, so metres are assumed
  bool z_up = false;           ///< z is up and y points away; otherwise y is up
  bool up_stated = false;      ///< false: not stated, so y is assumed
  /// The importer subtracted this from each position, because floats at that distance from the origin are too coarse
  /// (import/file_positions.hpp). In the units and axes of the positions. Zero for meshes near the origin.
  Vec3d offset{};
};

/// A node of the source above one or several mesh instances, or a mesh of the source that has a name of its own.
struct NodeGroup {
  std::string name;                 ///< UTF-8, not empty
  std::uint32_t parent = kNoIndex;  ///< index into Mesh::groups, lower than the group's own; kNoIndex: none
  friend bool operator==(const NodeGroup&, const NodeGroup&) = default;
};

/// A node of the source without a mesh, and without one below it: a socket, the place of a lamp. Answers have it below their
/// root.
struct EmptyNode {
  std::string name;  ///< UTF-8, possibly repeated
  /// From the node to the frame of Mesh::positions: the columns of the linear part, which are perpendicular to each other and
  /// not zero, and the translation.
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, t{0, 0, 0};
  std::string extras{};  ///< as in Mesh::node_extras
  friend bool operator==(const EmptyNode&, const EmptyNode&) = default;
};

/// How a node of the source placed a mesh that several nodes may share.
struct MeshInstance {
  std::uint32_t mesh =
      kNoIndex;  ///< number of the mesh in the source; kNoIndex: the vertices depend on more than a transform
  /// From the mesh's coordinates to the frame of Mesh::positions: the columns of the linear part, and the translation.
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, t{0, 0, 0};
  friend bool operator==(const MeshInstance&, const MeshInstance&) = default;
};

struct Mesh {
  /// Per wedge, right-handed, in the frame of the scene's root, less frame.offset. For an imported mesh, metres and y up
  /// only after to_metres_y_up() (mesh/frame.hpp).
  std::vector<Vec3f> positions;
  SourceFrame frame;
  Attributes attributes;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< wedge ids, counter-clockwise seen from outside
  std::vector<std::uint32_t> material;  ///< per triangle: index into library->materials, or kNoIndex
  std::vector<std::uint32_t> node;      ///< per triangle: index into node_names
  std::vector<std::string> node_names;  ///< mesh instances of the source, UTF-8, possibly repeated
  std::vector<NodeGroup> groups{};      ///< parents come before their children
  /// Per node: its innermost group, or kNoIndex; empty: no groups
  std::vector<std::uint32_t> group_of_node{};
  std::vector<MeshInstance> instances{};  ///< one for each of node_names; empty: none is known
  /// Per node: the members of its extras, as JSON text without the braces ("\"hp\":120"); an empty text: none. Empty: no node
  /// has any. Without the members `fracture`, `intact` and `whole`, which answers write themselves.
  std::vector<std::string> node_extras{};
  std::vector<EmptyNode> empty_nodes{};
  std::shared_ptr<const SourceTree> source_tree{};  ///< null: the nodes of the source are not in a tree
  /// Per triangle (surface_color/surface_colors.hpp); empty: none is known
  std::vector<SurfaceColor> triangle_color;
  std::shared_ptr<const MaterialLibrary> library = empty_library();
  std::vector<GivenHull> given_hulls{};  ///< see mesh/proxies.hpp; none until take_proxies()
  std::string copyright;                 ///< asset.copyright of the source, copied to the output
  /// The rest of the scene, which is not fractured (mesh/selection.hpp) and is written unchanged with the
  /// fragments. Has the same frame, node_names, instances and library. Null if there is none.
  std::shared_ptr<const Mesh> passed_through;
  Remarks remarks;  ///< what the importer changed (baked skins, …)
  /// Things that the importer left out (lights, animations, …); see shorten_dropped()
  std::vector<Dropped> dropped;
};

}  // namespace fracture
