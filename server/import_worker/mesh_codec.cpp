#include "server/import_worker/mesh_codec.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/json_reader.hpp"
#include "common/base/pacer.hpp"
#include "common/base/utf8.hpp"
#include "common/import/text_encoding.hpp"
#include "common/mesh/copied_limits.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/source_tree.hpp"
#include "server/import_worker/byte_stream.hpp"

namespace fracture {
namespace {

using nlohmann::json;

constexpr std::uint32_t kMagic = 0x37524d46;  // "FMR7"; the digit is raised with every change of the layout
enum Kind : std::uint32_t { kMesh = 1, kError = 2 };

/// Maximum length of an error's text, and maximum number of UV or colour sets. glTF readers support far fewer sets.
constexpr std::size_t kMaxDetail = 16 * 1024, kMaxSets = 64;

/// Memory limit for a list while it is parsed. A growing list takes up to twice its final size.
constexpr std::size_t kMaxListBytes = 2 * kMaxLibraryBytes;

std::string dump(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

void write_texts(ByteWriter& out, const std::vector<std::string>& texts) {
  out.value<std::uint64_t>(texts.size());
  for (const std::string& text : texts) out.text(text);
}

template <class T>
void write_sets(ByteWriter& out, const std::vector<std::vector<T>>& sets) {
  out.value<std::uint64_t>(sets.size());
  for (const auto& set : sets) out.array(set);
}

void write_source_tree(ByteWriter& out, const SourceTree& tree) {
  out.value<std::uint64_t>(tree.nodes.size());
  for (const SourceNode& node : tree.nodes) {
    out.text(node.name);
    out.value(node.parent);
    out.text(node.extras);
  }
  out.array(tree.of_instance);
}

/// Returns roughly the size of the arrays, so that the output buffer need not grow while they are written.
std::size_t bulk_of(const Mesh& mesh) {
  const Attributes& a = mesh.attributes;
  const std::size_t wedge =
      sizeof(Vec3f) * 2 + sizeof(Vec4f) + sizeof(Vec2f) * a.uvs.size() + sizeof(Vec4f) * a.colors.size();
  std::size_t bytes = 4096 + mesh.positions.size() * wedge +
                      mesh.triangles.size() * (5 * sizeof(std::uint32_t) + sizeof(SurfaceColor));
  for (const Image& image : mesh.library->images) bytes += image.bytes.size();
  return bytes;
}

void write_mesh(ByteWriter& out, const Mesh& mesh) {
  out.reserve(bulk_of(mesh));
  out.value(mesh.frame.metres);
  for (const bool flag : {mesh.frame.metres_stated, mesh.frame.z_up, mesh.frame.up_stated})
    out.value<std::uint8_t>(flag);
  for (int axis = 0; axis < 3; ++axis) out.value(mesh.frame.offset[axis]);
  out.array(mesh.positions);
  out.array(mesh.attributes.normals);
  out.array(mesh.attributes.tangents);
  write_sets(out, mesh.attributes.uvs);
  write_sets(out, mesh.attributes.colors);
  out.array(mesh.triangles);
  out.array(mesh.material);
  out.array(mesh.node);
  out.array(mesh.triangle_color);
  write_texts(out, mesh.node_names);
  write_texts(out, mesh.node_extras);
  out.value<std::uint64_t>(mesh.empty_nodes.size());
  for (const EmptyNode& node : mesh.empty_nodes) {
    out.text(node.name);
    out.text(node.extras);
    for (const Vec3d& column : {node.x, node.y, node.z, node.t}) out.value(column);
  }
  out.value<std::uint64_t>(mesh.groups.size());
  for (const NodeGroup& group : mesh.groups) {
    out.text(group.name);
    out.value(group.parent);
  }
  out.array(mesh.group_of_node);
  out.value<std::uint8_t>(mesh.source_tree != nullptr);
  if (mesh.source_tree) write_source_tree(out, *mesh.source_tree);
  std::vector<std::uint32_t> meshes;  // two arrays, because MeshInstance has padding
  std::vector<std::array<Vec3d, 4>> transforms;
  for (const MeshInstance& instance : mesh.instances) {
    meshes.push_back(instance.mesh);
    transforms.push_back({instance.x, instance.y, instance.z, instance.t});
  }
  out.array(meshes);
  out.array(transforms);
  const MaterialLibrary& library = *mesh.library;
  for (const json* list : json_lists(library)) out.text(dump(*list));
  out.value<std::uint64_t>(library.images.size());
  for (const Image& image : library.images) {
    out.text(image.name);
    out.text(image.mime_type);
    out.array(image.bytes);
  }
  write_texts(out, library.extensions_used);
  write_texts(out, library.extensions_required);
  out.text(mesh.copyright);
  write_texts(out, mesh.remarks.warnings);
  write_texts(out, mesh.remarks.notes);
  out.value<std::uint64_t>(mesh.dropped.size());
  for (const Dropped& entry : mesh.dropped)
    for (const std::string* text : {&entry.what, &entry.name, &entry.reason}) out.text(*text);
}

void require(bool promise, const char* what) {
  if (!promise) throw BadReply(what);
}

std::vector<std::string> read_texts(ByteReader& in) {
  std::vector<std::string> texts(in.length(sizeof(std::uint64_t)));
  for (std::string& text : texts) {
    text = in.text();
    require(is_utf8(text), "text is not UTF-8");
  }
  return texts;
}

template <class T>
std::vector<std::vector<T>> read_sets(ByteReader& in) {
  const std::uint64_t count = in.length(sizeof(std::uint64_t));
  require(count <= kMaxSets, "there are too many attribute sets");
  std::vector<std::vector<T>> sets(count);
  for (auto& set : sets) set = in.array<T>();
  return sets;
}

json read_json(ByteReader& in, const ImportLimits& limits) {
  const std::string text = in.text();
  // The depth is limited because everything that visits the values recurses. It may exceed the file's limit by a few levels,
  // because lists enclose the file's objects.
  auto read = fracture::read_json(text, {limits.max_json_depth + 8, kMaxListBytes}, in.execution());
  if (!read) throw BadReply("a JSON " + to_text(read.error()));
  return std::move(read->value);
}

/// The text is written into answers as it is, so it must be the members of an object.
void check_extras(const std::string& members, const ImportLimits& limits, const Execution& execution) {
  if (members.empty()) return;
  const auto read =
      fracture::read_json("{" + members + "}", {limits.max_json_depth + 8, kMaxListBytes}, execution);
  require(read && read->value.is_object() && !read->value.empty(), "the extras of a node are not JSON");
  for (const char* own : {"fracture", "intact", "whole"})
    require(!read->value.contains(own), "a node's extras contain members that only an answer may have");
}

void read_empty_node(ByteReader& in, const ImportLimits& limits, EmptyNode& node) {
  node.name = in.text();
  node.extras = in.text();
  require(is_utf8(node.name) && is_utf8(node.extras), "text is not UTF-8");
  check_extras(node.extras, limits, in.execution());
  for (Vec3d* column : {&node.x, &node.y, &node.z, &node.t}) {
    *column = in.value<Vec3d>();
    require(std::isfinite(column->x) && std::isfinite(column->y) && std::isfinite(column->z),
            "a node's transform is not finite");
  }
}

SourceTree read_source_tree(ByteReader& in, const ImportLimits& limits) {
  SourceTree tree;
  tree.nodes.resize(in.length(2 * sizeof(std::uint64_t) + sizeof(std::uint32_t)));
  std::vector<std::uint32_t> level;
  for (SourceNode& node : tree.nodes) {
    node.name = in.text();
    node.parent = in.value<std::uint32_t>();
    node.extras = in.text();
    require(!node.name.empty() && is_utf8(node.name) && is_utf8(node.extras), "a text is empty or not UTF-8");
    require(node.name.size() <= kMostNodeName, "the name of a source node is too long");
    check_extras(node.extras, limits, in.execution());
    require(node.parent < level.size() || node.parent == kNoIndex, "a source node is not part of a tree");
    level.push_back(node.parent == kNoIndex ? 1 : level[node.parent] + 1);
    require(level.back() <= kMostSourceLevels, "a source node is nested too deeply");
  }
  tree.of_instance = in.array<std::uint32_t>();
  for (const std::uint32_t node : tree.of_instance)
    require(node < tree.nodes.size(), "an instance is not a source node");
  require(std::is_sorted(tree.of_instance.begin(), tree.of_instance.end()),
          "the instances are not in the order of the source nodes");
  return tree;
}

json read_objects(ByteReader& in, const ImportLimits& limits) {
  json list = read_json(in, limits);
  require(list.is_array(), "a list of the material library is not an array");
  for (const json& object : list)
    require(object.is_object(), "a material, texture or sampler is not an object");
  return list;
}

template <class T>
bool is_finite(const T& value) {
  static_assert(sizeof(T) % sizeof(float) == 0);
  const auto* begin = reinterpret_cast<const float*>(&value);
  return std::all_of(begin, begin + sizeof(T) / sizeof(float), [](float x) { return std::isfinite(x); });
}

void check_mesh(const Mesh& mesh, const ImportLimits& limits, const Execution& execution) {
  const std::size_t wedges = mesh.positions.size(), triangles = mesh.triangles.size();
  require(std::isfinite(mesh.frame.metres) && mesh.frame.metres > 0, "the unit is not a positive length");
  for (int axis = 0; axis < 3; ++axis)
    require(std::isfinite(mesh.frame.offset[axis]), "the offset is not finite");
  require(triangles > 0 && triangles <= limits.max_triangles, "the number of triangles is out of range");
  require(wedges < kNoIndex, "there are too many vertices");
  const auto complete = [&](const auto& values) {
    require(values.empty() || values.size() == wedges, "an attribute is not given for every vertex");
    require(all_of_with_polls(execution, values, [](const auto& value) { return is_finite(value); }),
            "an attribute is not finite");
  };
  complete(mesh.positions);
  complete(mesh.attributes.normals);
  complete(mesh.attributes.tangents);
  for (const auto& set : mesh.attributes.uvs) complete(set);
  for (const auto& set : mesh.attributes.colors) complete(set);
  const auto names_vertices = [wedges](const auto& t) {
    return t[0] < wedges && t[1] < wedges && t[2] < wedges;
  };
  require(all_of_with_polls(execution, mesh.triangles, names_vertices), "a triangle names no vertex");
  require(mesh.material.size() == triangles && mesh.node.size() == triangles,
          "a triangle has no material or node");
  require(mesh.triangle_color.empty() || mesh.triangle_color.size() == triangles,
          "the colour is not given for every triangle");
  const std::size_t nodes = mesh.node_names.size();
  require(all_of_with_polls(execution, mesh.node, [nodes](std::uint32_t node) { return node < nodes; }),
          "a triangle names no node");
  for (std::size_t k = 0; k < mesh.groups.size(); ++k)
    require(mesh.groups[k].parent < k || mesh.groups[k].parent == kNoIndex,
            "a group of nodes is not part of a tree");
  require(mesh.node_extras.empty() || mesh.node_extras.size() == mesh.node_names.size(),
          "the extras are not given for every node");
  require(mesh.group_of_node.empty() || mesh.group_of_node.size() == mesh.node_names.size(),
          "the group is not given for every node");
  for (const std::uint32_t group : mesh.group_of_node)
    require(group < mesh.groups.size() || group == kNoIndex, "a node names no group");
  require(!mesh.source_tree || mesh.source_tree->of_instance.size() == mesh.node_names.size(),
          "the source node is not given for every instance");
  require(mesh.instances.empty() || mesh.instances.size() == mesh.node_names.size(),
          "the instance is not given for every node");
  const std::size_t materials = mesh.library->materials.size();
  const auto names_material = [materials](std::uint32_t slot) {
    return slot < materials || slot == kNoIndex;
  };
  require(all_of_with_polls(execution, mesh.material, names_material), "a triangle names no material");
}

Mesh read_mesh(ByteReader& in, const ImportLimits& limits, const Execution& execution) {
  Mesh mesh;
  mesh.frame.metres = in.value<double>();
  mesh.frame.metres_stated = in.value<std::uint8_t>() != 0;
  mesh.frame.z_up = in.value<std::uint8_t>() != 0;
  mesh.frame.up_stated = in.value<std::uint8_t>() != 0;
  for (int axis = 0; axis < 3; ++axis) mesh.frame.offset[axis] = in.value<double>();
  mesh.positions = in.array<Vec3f>();
  mesh.attributes.normals = in.array<Vec3f>();
  mesh.attributes.tangents = in.array<Vec4f>();
  mesh.attributes.uvs = read_sets<Vec2f>(in);
  mesh.attributes.colors = read_sets<Vec4f>(in);
  mesh.triangles = in.array<std::array<std::uint32_t, 3>>();
  mesh.material = in.array<std::uint32_t>();
  mesh.node = in.array<std::uint32_t>();
  mesh.triangle_color = in.array<SurfaceColor>();
  mesh.node_names = read_texts(in);
  mesh.node_extras = read_texts(in);
  const std::string* before = nullptr;
  for (const std::string& extras : mesh.node_extras) {  // the instances of a node have the same ones
    if (before == nullptr || extras != *before) check_extras(extras, limits, execution);
    before = &extras;
  }
  mesh.empty_nodes.resize(in.length(2 * sizeof(std::uint64_t) + 4 * sizeof(Vec3d)));
  for (EmptyNode& node : mesh.empty_nodes) read_empty_node(in, limits, node);
  mesh.groups.resize(in.length(sizeof(std::uint64_t) + sizeof(std::uint32_t)));
  for (NodeGroup& group : mesh.groups) {
    group.name = in.text();
    group.parent = in.value<std::uint32_t>();
    require(is_utf8(group.name), "text is not UTF-8");
  }
  mesh.group_of_node = in.array<std::uint32_t>();
  if (in.value<std::uint8_t>() != 0)
    mesh.source_tree = std::make_shared<const SourceTree>(read_source_tree(in, limits));
  const std::vector<std::uint32_t> meshes = in.array<std::uint32_t>();
  const std::vector<std::array<Vec3d, 4>> transforms = in.array<std::array<Vec3d, 4>>();
  require(meshes.size() == transforms.size(), "the transform is not given for every instance");
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const auto& [x, y, z, t] = transforms[k];
    mesh.instances.push_back({meshes[k], x, y, z, t});
  }
  MaterialLibrary library;
  for (json* list : json_lists(library)) *list = read_objects(in, limits);
  require(has_sound_variants(library), "the variants of a material do not exist or are too long");
  library.images.resize(in.length(3 * sizeof(std::uint64_t)));
  for (Image& image : library.images) {
    image.name = in.text();
    image.mime_type = in.text();
    image.bytes = in.array<std::uint8_t>();
    require(is_utf8(image.name) && is_utf8(image.mime_type), "the name of an image is not UTF-8");
  }
  library.extensions_used = read_texts(in);
  library.extensions_required = read_texts(in);
  mesh.library = std::make_shared<const MaterialLibrary>(std::move(library));
  mesh.copyright = in.text();
  require(is_utf8(mesh.copyright), "the copyright is not UTF-8");
  mesh.remarks.warnings = read_texts(in);
  mesh.remarks.notes = read_texts(in);
  mesh.dropped.resize(in.length(3 * sizeof(std::uint64_t)));
  for (Dropped& entry : mesh.dropped)
    for (std::string* text : {&entry.what, &entry.name, &entry.reason}) {
      *text = in.text();
      require(is_utf8(*text), "text is not UTF-8");
    }
  require(in.at_end(), "the mesh has too few or too many bytes");
  check_mesh(mesh, limits, execution);
  return mesh;
}

/// Returns whether an import may end with this code. With other codes, a worker could blame the server, for example.
bool is_import_error(ErrorCode code) {
  switch (code) {
    case ErrorCode::kEmptyBody:
    case ErrorCode::kMalformedMesh:
    case ErrorCode::kUnsupportedFeature:
    case ErrorCode::kExternalResource:
    case ErrorCode::kImporterLimit:
    case ErrorCode::kTooLarge:
    case ErrorCode::kEmptyMesh:
    case ErrorCode::kNotFinite:
      return true;
    default:
      return false;
  }
}

Error read_error(ByteReader& in, const ImportLimits& limits) {
  Error error{static_cast<ErrorCode>(in.value<std::uint32_t>()), in.text(), in.text(), {}};
  require(in.good() && is_import_error(error.code), "the error has a code that imports do not use");
  require(!error.detail.empty() && error.detail.size() + error.pointer.size() <= kMaxDetail,
          "the text of the error is empty or too long");
  error.detail = name_as_utf8(error.detail);
  error.pointer = name_as_utf8(error.pointer);
  error.extra = Figures(read_json(in, limits));
  require(error.extra->is_object() && in.at_end(), "the figures of the error are not an object");
  return error;
}

}  // namespace

std::vector<std::byte> encode_reply(const Expected<Mesh>& imported) {
  ByteWriter out;
  out.value(kMagic);
  out.value<std::uint32_t>(imported ? kMesh : kError);
  if (imported) {
    write_mesh(out, *imported);
  } else {
    const Error& error = imported.error();
    out.value(static_cast<std::uint32_t>(error.code));
    out.text(error.detail.substr(0, kMaxDetail / 2));
    out.text(error.pointer.substr(0, kMaxDetail / 2));
    out.text(dump(*error.extra));
  }
  return out.take();
}

Expected<Mesh> decode_reply(std::span<const std::byte> bytes, const ImportLimits& limits,
                            const Execution& execution) {
  ByteReader in(bytes, execution);
  require(in.value<std::uint32_t>() == kMagic, "the reply has a different version");
  const auto kind = in.value<std::uint32_t>();
  if (kind == kError) return tl::unexpected<Error>(read_error(in, limits));
  require(kind == kMesh, "the reply is neither a mesh nor an error");
  return read_mesh(in, limits, execution);
}

}  // namespace fracture
