#include "common/import/polygon_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "common/base/words.hpp"
#include "common/import/limit_words.hpp"
#include "common/import/mesh_builder.hpp"
#include "common/import/polygon_triangles.hpp"
#include "common/import/refused.hpp"
#include "common/import/text_encoding.hpp"
#include "common/import/transform.hpp"

namespace fracture {
namespace {

using CornerTriangle = std::array<std::uint32_t, 3>;

/// Longer names are cut. A file can contain a line of any length.
constexpr std::size_t kLongestPartName = 1000;

/// The beginning of a long name. Characters of UTF-8 stay whole, because other text would be taken for Latin-1.
std::string_view cut(std::string_view name) {
  if (name.size() <= kLongestPartName) return name;
  std::size_t end = kLongestPartName;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
  return name.substr(0, end);
}

[[noreturn]] void refuse_triangles(std::uint64_t count, const ImportLimits& limits) {
  refuse(ErrorCode::kTooLarge,
         "The file has at least " + counted(count, "face", "faces") + "; the limit is " +
             triangle_limit(limits.max_triangles) + ". " + kSmallerMesh,
         {}, {{"triangles", count}, {"limit", limits.max_triangles}});
}

/// The triangles of all faces, with corners as indices into file.corners, and their materials.
struct DividedFaces {
  std::vector<CornerTriangle> triangles;
  std::vector<std::uint32_t> materials;
  std::vector<std::size_t> part_end;  ///< per part: the end of its triangles
};

DividedFaces divide_faces(const PolygonFile& file) {
  DividedFaces divided;
  divided.triangles.reserve(file.triangles);
  divided.materials.reserve(file.triangles);
  std::vector<Vec3d> polygon;
  std::uint32_t begin = 0;
  std::size_t face = 0;
  for (const PolygonFile::Part& part : file.parts) {
    for (; face < part.face_end; ++face) {
      const std::uint32_t end = file.face_end[face];
      if (end - begin == 3) {
        divided.triangles.push_back({begin, begin + 1, begin + 2});
      } else {
        polygon.clear();
        for (std::uint32_t k = begin; k < end; ++k) polygon.push_back(file.positions[file.corners[k]]);
        append_polygon(polygon, begin, divided.triangles);
      }
      divided.materials.resize(divided.triangles.size(),
                               file.face_material.empty() ? file.material : file.face_material[face]);
      begin = end;
    }
    divided.part_end.push_back(divided.triangles.size());
  }
  return divided;
}

/// Marks the positions of corners as used. Vertices that no face uses may have any coordinates, as scanners write them.
void use_positions(PolygonFile& file) {
  for (const std::uint32_t vertex : file.corners) {
    if (FilePositions::fits(file.positions[vertex])) {
      file.positions.use(vertex);
      continue;
    }
    const auto bad = std::lower_bound(file.not_finite.begin(), file.not_finite.end(), vertex,
                                      [](const auto& entry, std::size_t v) { return entry.first < v; });
    refuse(ErrorCode::kNotFinite,
           "Vertex " + std::to_string(vertex) + " (counted from 0, at " + file.places(bad->second) +
               ") has a coordinate that is not finite or exceeds 3.4e38. Repair the mesh in a "
               "modelling tool.",
           {}, {{"vertex", vertex}});
  }
}

template <class T>
std::vector<T> between(const std::vector<T>& values, std::size_t begin, std::size_t end) {
  if (values.empty()) return {};
  return {values.begin() + static_cast<std::ptrdiff_t>(begin),
          values.begin() + static_cast<std::ptrdiff_t>(end)};
}

template <class T>
std::vector<T> at_corners(const std::vector<T>& values, const std::vector<std::uint32_t>& corners) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(corners.size());
  for (const std::uint32_t vertex : corners) result.push_back(values[vertex]);
  return result;
}

/// The vertices in [begin, end) as wedges.
Surface wedges_of_vertices(const PolygonFile& file, const std::vector<Vec3f>& positions, std::size_t begin,
                           std::size_t end) {
  Surface surface;
  surface.positions = between(positions, begin, end);
  surface.attributes.normals = between(file.normals, begin, end);
  if (!file.uvs.empty()) surface.attributes.uvs.push_back(between(file.uvs, begin, end));
  if (!file.colors.empty()) surface.attributes.colors.push_back(between(file.colors, begin, end));
  return surface;
}

/// All corners as wedges, because each has its own texture coordinates.
Surface wedges_of_corners(const PolygonFile& file, const std::vector<Vec3f>& positions) {
  Surface surface;
  surface.positions = at_corners(positions, file.corners);
  surface.attributes.normals = at_corners(file.normals, file.corners);
  surface.attributes.uvs.push_back(file.corner_uvs);
  if (!file.colors.empty()) surface.attributes.colors.push_back(at_corners(file.colors, file.corners));
  return surface;
}

void add_parts(const PolygonFile& file, const DividedFaces& divided, const std::vector<Vec3f>& positions,
               MeshBuilder& builder) {
  std::size_t vertex = 0, triangle = 0;
  for (std::size_t k = 0; k < file.parts.size(); ++k) {
    const PolygonFile::Part& part = file.parts[k];
    const std::string name = name_as_utf8(cut(part.name));
    builder.begin_node(name.empty() ? "mesh" : name);
    if (triangle != divided.part_end[k]) {
      const bool own_uvs = !file.corner_uvs.empty();
      Surface surface = own_uvs ? wedges_of_corners(file, positions)
                                : wedges_of_vertices(file, positions, vertex, part.vertex_end);
      surface.triangles = between(divided.triangles, triangle, divided.part_end[k]);
      surface.materials = between(divided.materials, triangle, divided.part_end[k]);
      if (!own_uvs)
        for (CornerTriangle& t : surface.triangles)
          for (std::uint32_t& corner : t) corner = file.corners[corner] - static_cast<std::uint32_t>(vertex);
      merge_identical_wedges(surface);
      if (auto added = builder.add(std::move(surface)); !added) throw Refused{added.error()};
    }
    vertex = part.vertex_end;
    triangle = divided.part_end[k];
  }
}

}  // namespace

void PolygonFile::add_position(const Vec3d& position, std::size_t place) {
  if (!FilePositions::fits(position)) not_finite.emplace_back(positions.size(), place);
  positions.add(position);
}

void PolygonFile::add_corner(double vertex, std::size_t count, std::size_t place) {
  if (!(vertex >= 0 && vertex < static_cast<double>(count)) || vertex != std::floor(vertex)) {
    const std::string index = std::fabs(vertex) < 1e15 && vertex == std::floor(vertex)
                                  ? std::to_string(static_cast<std::int64_t>(vertex))
                                  : std::to_string(vertex);
    refuse(ErrorCode::kMalformedMesh, "Face " + std::to_string(face_end.size()) + " (counted from 0, at " +
                                          places(place) + ") names vertex " + index + "; the file has " +
                                          std::to_string(count) +
                                          " vertices, counted from 0. Export the file again.");
  }
  corners.push_back(static_cast<std::uint32_t>(vertex));
}

void PolygonFile::limit_corners(std::uint64_t count, const ImportLimits& limits) const {
  if (count > 2 && count - 2 > limits.max_triangles - std::min(triangles, limits.max_triangles))
    refuse_triangles(triangles + count - 2, limits);
}

void PolygonFile::end_face(const ImportLimits& limits) {
  const std::size_t begin = face_end.empty() ? 0 : face_end.back();
  const std::size_t count = corners.size() - begin;
  if (count < 3) {
    corners.resize(begin);
    return;
  }
  triangles += count - 2;
  if (triangles > limits.max_triangles) refuse_triangles(triangles, limits);
  if (corners.size() >= kNoIndex) refuse_triangles(triangles, limits);
  face_end.push_back(static_cast<std::uint32_t>(corners.size()));
}

void PolygonFile::end_part(std::string name) {
  parts.push_back({std::move(name), positions.size(), face_end.size()});
}

void limit_faces(std::uint64_t faces, const ImportLimits& limits) {
  if (faces > limits.max_triangles) refuse_triangles(faces, limits);
}

void limit_vertices(std::uint64_t vertices, std::uint64_t bytes, const ImportLimits& limits) {
  if (vertices < kNoIndex && vertices <= limits.max_decoded_bytes / bytes) return;
  refuse(ErrorCode::kTooLarge,
         "The file declares " + grouped(vertices) + " vertices of " + std::to_string(bytes) +
             " bytes; the limit for a mesh is " + decoded_limit(limits.max_decoded_bytes) + ". " +
             kSmallerMesh,
         {}, {{"limit", limits.max_decoded_bytes}});
}

nlohmann::json plain_material(const std::array<double, 3>& color) {
  return {{"doubleSided", true},
          {"pbrMetallicRoughness",
           {{"metallicFactor", 0}, {"baseColorFactor", {color[0], color[1], color[2], 1.0}}}}};
}

Expected<Mesh> finish_polygon_file(PolygonFile file, const ImportLimits& limits) {
  try {
    use_positions(file);
    const DividedFaces divided = divide_faces(file);
    const Vec3d offset = file.positions.offset();
    const std::vector<Vec3f> positions = std::exchange(file.positions, {}).rounded(offset);
    for (Vec3f& n : file.normals) n = unit_float(to_double(n));
    for (auto* uvs : {&file.uvs, &file.corner_uvs})
      for (Vec2f& uv : *uvs) uv.y = 1.0f - uv.y;  // glTF's v points down
    MeshBuilder builder(limits);
    builder.remarks().add(file.remarks);
    builder.set_library(std::move(file.library));
    add_parts(file, divided, positions, builder);
    Expected<Mesh> mesh = builder.finish();
    if (!mesh) return mesh;
    mesh->frame.offset = offset;
    mesh->dropped = std::move(file.dropped);
    return mesh;
  } catch (const Refused& refused) {
    return tl::unexpected<Error>(refused.error);
  }
}

}  // namespace fracture
