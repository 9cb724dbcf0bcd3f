#include <algorithm>
#include <cmath>
#include <limits>

#include "common/outputs/outputs.hpp"

namespace fracture::outputs {
namespace {

/// Attributes that some object has. All vertices of the file get them.
struct Columns {
  bool normals = false, uvs = false, colors = false;

  explicit Columns(const Answer& answer) {
    for (const Object& object : answer.objects) {
      normals = normals || !object.normals.empty();
      uvs = uvs || !object.uvs.empty();
      colors = colors || !object.colors.empty();
    }
  }
};

void write_head(Blocks& out, const Answer& answer, const Columns& columns) {
  out.text("ply\nformat binary_little_endian 1.0\ncomment ").text(answer.generator);
  out.text("\ncomment metres, y up\n");
  if (const std::string offset = answer.offset_text(); !offset.empty())
    out.text("comment ").text(offset).text("\n");
  std::int32_t fragment = 0;
  for (const Object& object : answer.objects)
    if (object.id)
      out.text("comment fragment ")
          .number(fragment++)
          .text(" ")
          .text(object.name)
          .text(" id ")
          .number(*object.id)
          .text("\n");
  out.text("element vertex ").number(answer.vertices());
  out.text("\nproperty float x\nproperty float y\nproperty float z\n");
  if (columns.normals) out.text("property float nx\nproperty float ny\nproperty float nz\n");
  if (columns.uvs) out.text("property float s\nproperty float t\n");
  if (columns.colors)
    out.text("property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n");
  out.text("property int fragment\nelement face ").number(answer.triangles());
  out.text("\nproperty list uchar int vertex_indices\nproperty int fragment\nend_header\n");
}

void write_color(Blocks& out, const Object& object, std::size_t vertex, VertexColors colors) {
  for (std::size_t k = 0; k < 4; ++k) {
    const double component = object.colors.empty() ? 1 : object.colors.at(vertex, k);
    const bool curved = colors == VertexColors::kToSrgb && k < 3;
    const double shown = std::clamp(curved ? to_srgb(component) : component, 0.0, 1.0);
    out.raw(static_cast<std::uint8_t>(std::lround(255 * shown)));
  }
}

void write_vertices(Blocks& out, const Object& object, const Columns& columns, VertexColors colors,
                    std::int32_t fragment) {
  for (std::size_t v = 0; v < object.positions.size(); ++v) {
    const Vec3f p = object.position(v);
    out.raw(p.x).raw(p.y).raw(p.z);
    if (columns.normals) {
      const Vec3f n = object.normals.empty() ? Vec3f{} : object.normal(v);
      out.raw(n.x).raw(n.y).raw(n.z);
    }
    if (columns.uvs) {
      const bool have = !object.uvs.empty();
      out.raw(have ? object.uvs.front().at(v, 0) : 0.0f);
      out.raw(have ? 1 - object.uvs.front().at(v, 1) : 0.0f);  // glTF's v points down
    }
    if (columns.colors) write_color(out, object, v, colors);
    out.raw(fragment);
  }
}

void write_faces(Blocks& out, const Object& object, std::size_t first, std::int32_t fragment) {
  for (const Primitive& primitive : object.primitives)
    for (std::size_t k = 0; k < primitive.indices.size(); k += 3) {
      out.raw(std::uint8_t{3});
      for (std::size_t c = k; c < k + 3; ++c)
        out.raw(static_cast<std::int32_t>(first + primitive.indices[c]));
      out.raw(fragment);
    }
}

}  // namespace

bool write_ply(const Answer& answer, VertexColors colors, const Sink& sink) {
  if (answer.vertices() > std::size_t{std::numeric_limits<std::int32_t>::max()})
    throw InternalError("the PLY would have more than 2^31 - 1 vertices");  // a GLB is at most 4 GiB
  Blocks out(sink);
  const Columns columns(answer);
  write_head(out, answer, columns);
  const auto each = [&](const auto& write) {
    std::int32_t fragment = 0;
    for (const Object& object : answer.objects) {
      if (!out.good()) return;
      write(object, object.id ? fragment++ : object.carried ? fragment - 1 : -1);
    }
  };
  each([&](const Object& object, std::int32_t fragment) {
    write_vertices(out, object, columns, colors, fragment);
  });
  std::size_t first = 0;
  each([&](const Object& object, std::int32_t fragment) {
    write_faces(out, object, first, fragment);
    first += object.positions.size();
  });
  return out.finish();
}

}  // namespace fracture::outputs
