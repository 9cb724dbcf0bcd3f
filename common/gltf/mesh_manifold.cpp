#include "common/gltf/mesh_manifold.hpp"

#include <vector>

#include "common/base/scratch.hpp"
#include "common/mesh/gltf_component.hpp"

namespace fracture {
namespace {

/// Which corners are merged, and with which vertices.
struct Merges {
  std::vector<std::uint32_t> corners, vertices;

  std::size_t bytes() const { return bytes_of_vectors(corners, vertices); }
  void release() { release_vectors(corners, vertices); }
};

}  // namespace

void write_mesh_manifold(JsonText& json, const Fragment& f, const WrittenMesh& mesh, Accessors& accessors) {
  if (f.topology.size() != f.positions.size())
    throw InternalError("fragment " + std::to_string(f.id) + ": topology and vertices differ in number");
  auto& [corners, vertices] = thread_scratch<Merges>();
  corners.clear();
  vertices.clear();
  for (std::size_t k = 0; k < f.indices.size(); ++k) {
    if (k % 65536 == 65535) accessors.execution().poll();
    const std::uint32_t to = f.topology[f.indices[k]];
    if (to == f.indices[k]) continue;
    if (to >= f.positions.size())
      throw InternalError("fragment " + std::to_string(f.id) + ": topology names a vertex that is not there");
    corners.push_back(static_cast<std::uint32_t>(k));
    vertices.push_back(to);
  }

  const int vertex_type = mesh.wide ? component_type::kUnsignedInt : component_type::kUnsignedShort;
  const bool wide_corners = f.indices.size() > kMaxShortVertices;
  const int corner_type = wide_corners ? component_type::kUnsignedInt : component_type::kUnsignedShort;
  std::size_t view = 0, corners_at = 0, vertices_at = 0;
  if (!corners.empty()) {
    view = accessors.view("merges", 0, 0);
    corners_at = append_indices(accessors.bytes(view), corners.data(), corners.size(), wide_corners);
    vertices_at = append_indices(accessors.bytes(view), vertices.data(), vertices.size(), mesh.wide);
  }

  const std::size_t merged = accessors.count();
  JsonText& accessor = accessors.begin().member("bufferView", mesh.index_view);
  if (mesh.indices_at > 0) accessor.member("byteOffset", mesh.indices_at);
  accessor.member("componentType", vertex_type).member("count", f.indices.size()).member("type", "SCALAR");
  if (!corners.empty()) {
    accessor.key("sparse").begin_object().member("count", corners.size());
    accessor.key("indices").begin_object().member("bufferView", view).member("byteOffset", corners_at);
    accessor.member("componentType", corner_type).end_object();
    accessor.key("values").begin_object().member("bufferView", view).member("byteOffset", vertices_at);
    accessor.end_object().end_object();
  }
  accessor.end_object();

  json.key("EXT_mesh_manifold").begin_object().key("manifoldPrimitive").begin_object();
  json.key("attributes").begin_object().member("POSITION", mesh.positions).end_object();
  json.member("indices", merged).end_object();
  if (!corners.empty()) {
    json.member("mergeIndices", accessors.add(view, corners_at, corner_type, corners.size(), "SCALAR"));
    json.member("mergeValues", accessors.add(view, vertices_at, vertex_type, vertices.size(), "SCALAR"));
  }
  json.end_object();
}

}  // namespace fracture
