#include "common/gltf/mesh_manifold.hpp"

#include <algorithm>
#include <cstring>

#include "common/base/error.hpp"
#include "common/gltf/vertex_data.hpp"
#include "common/mesh/gltf_component.hpp"

namespace fracture {
namespace {

/// Calls visit(corner, first vertex of its topology) for each corner with a different vertex.
template <class Visit>
void each_merged(const Fragment& f, Pacer& pacer, const Visit& visit) {
  pacer.each(0, f.indices.size(), [&](std::size_t k) {
    const std::uint32_t to = f.topology[f.indices[k]];
    if (to != f.indices[k]) visit(static_cast<std::uint32_t>(k), to);
  });
}

/// Writes numbers of type Index one after the other.
template <class Index>
class IndexSink {
 public:
  explicit IndexSink(Room out) : at_(out.data()) {}
  void operator()(std::uint32_t number) {
    const auto index = static_cast<Index>(number);
    std::memcpy(at_, &index, sizeof(index));
    at_ += sizeof(index);
  }

 private:
  std::uint8_t* at_;
};

template <class Index>
void write_corners(const Fragment& f, Room out, Pacer& pacer) {
  IndexSink<Index> sink(out);
  each_merged(f, pacer, [&](std::uint32_t corner, std::uint32_t) { sink(corner); });
}

template <class Index>
void write_vertices(const Fragment& f, Room out, Pacer& pacer) {
  IndexSink<Index> sink(out);
  each_merged(f, pacer, [&](std::uint32_t, std::uint32_t vertex) { sink(vertex); });
}

}  // namespace

std::size_t merged_corners(const Fragment& f, Pacer& pacer) {
  if (f.topology.size() != f.positions.size())
    throw InternalError("fragment " + std::to_string(f.id) +
                        ": topology and vertices have different lengths");
  std::size_t count = 0;
  std::uint32_t highest = 0;
  each_merged(f, pacer, [&](std::uint32_t, std::uint32_t vertex) {
    ++count;
    highest = std::max(highest, vertex);
  });
  if (highest >= f.positions.size())
    throw InternalError("fragment " + std::to_string(f.id) +
                        ": topology refers to a vertex that does not exist");
  return count;
}

void write_mesh_manifold(JsonText& json, const Fragment& f, const WrittenMesh& mesh, Accessors& accessors) {
  const int vertex_type = mesh.wide ? component_type::kUnsignedInt : component_type::kUnsignedShort;
  const bool wide_corners = f.indices.size() > kMaxShortVertices;
  const int corner_type = wide_corners ? component_type::kUnsignedInt : component_type::kUnsignedShort;
  std::size_t view = 0, corners_at = 0, vertices_at = 0;
  if (mesh.merged > 0) {
    BufferContents& contents = accessors.contents();
    view = contents.view("merges", 0, 0);
    corners_at = wide_corners ? contents.put<write_corners<std::uint32_t>>(view, 4 * mesh.merged, f)
                              : contents.put<write_corners<std::uint16_t>>(view, 2 * mesh.merged, f);
    vertices_at = mesh.wide ? contents.put<write_vertices<std::uint32_t>>(view, 4 * mesh.merged, f)
                            : contents.put<write_vertices<std::uint16_t>>(view, 2 * mesh.merged, f);
  }

  const std::size_t merged = accessors.count();
  JsonText& accessor = accessors.begin().member("bufferView", mesh.index_view);
  if (mesh.indices_at > 0) accessor.member("byteOffset", mesh.indices_at);
  accessor.member("componentType", vertex_type).member("count", f.indices.size()).member("type", "SCALAR");
  if (mesh.merged > 0) {
    accessor.key("sparse").begin_object().member("count", mesh.merged);
    accessor.key("indices").begin_object().member("bufferView", view).member("byteOffset", corners_at);
    accessor.member("componentType", corner_type).end_object();
    accessor.key("values").begin_object().member("bufferView", view).member("byteOffset", vertices_at);
    accessor.end_object().end_object();
  }
  accessor.end_object();

  json.key("EXT_mesh_manifold").begin_object().key("manifoldPrimitive").begin_object();
  json.key("attributes").begin_object().member("POSITION", mesh.positions).end_object();
  json.member("indices", merged).end_object();
  if (mesh.merged > 0) {
    json.member("mergeIndices", accessors.add(view, corners_at, corner_type, mesh.merged, "SCALAR"));
    json.member("mergeValues", accessors.add(view, vertices_at, vertex_type, mesh.merged, "SCALAR"));
  }
  json.end_object();
}

}  // namespace fracture
