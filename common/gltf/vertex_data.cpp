#include "common/gltf/vertex_data.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace fracture {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little-endian");

template <class Vec>
void append_raw(ViewBytes& view, const std::vector<Vec>& values) {
  if (!values.empty())
    std::memcpy(view.extend(values.size() * sizeof(Vec)), values.data(), values.size() * sizeof(Vec));
}

/// Well inside what validators accept, well outside what rounding three floats does.
bool is_unit(const Vec3d& v) { return std::abs(dot(v, v) - 1) < 1e-5; }

/// The unit vector in floats; false where there is no direction.
bool normalise(Vec3d& v) {
  const double l = length(v);
  if (!(l > 1e-30) || !std::isfinite(l)) return false;
  v = {v.x / l, v.y / l, v.z / l};
  return true;
}

Vec3f to_float(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// The direction of the first triangle at the vertex that has one.
Vec3d triangle_normal(const Fragment& fragment, std::size_t vertex) {
  for (std::size_t k = 0; k + 2 < fragment.indices.size(); k += 3) {
    const std::uint32_t* i = &fragment.indices[k];
    if (i[0] != vertex && i[1] != vertex && i[2] != vertex) continue;
    const Vec3d a = to_double(fragment.positions[i[0]]);
    Vec3d n = cross(to_double(fragment.positions[i[1]]) - a, to_double(fragment.positions[i[2]]) - a);
    if (normalise(n)) return n;
  }
  return {0, 0, 1};
}

Vec3d perpendicular_to(const Vec3d& n) {
  Vec3d t = std::abs(n.x) < 0.5 ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0});
  return normalise(t) ? t : Vec3d{1, 0, 0};
}

}  // namespace

void append_positions(ViewBytes& view, const std::vector<Vec3f>& positions, Vec3f& min, Vec3f& max) {
  append_raw(view, positions);
  min = max = positions.front();
  for (const Vec3f& p : positions) {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
}

void append_normals(ViewBytes& view, const Fragment& fragment) {
  const std::vector<Vec3f>& normals = fragment.attributes.normals;
  std::uint8_t* out = view.extend(normals.size() * sizeof(Vec3f));
  for (std::size_t v = 0; v < normals.size(); ++v, out += sizeof(Vec3f)) {
    Vec3f stored = normals[v];
    if (Vec3d n = to_double(stored); !is_unit(n)) {
      if (!normalise(n)) n = triangle_normal(fragment, v);
      stored = to_float(n);
    }
    std::memcpy(out, &stored, sizeof(Vec3f));
  }
}

void append_tangents(ViewBytes& view, const Fragment& fragment) {
  const std::vector<Vec4f>& tangents = fragment.attributes.tangents;
  std::uint8_t* out = view.extend(tangents.size() * sizeof(Vec4f));
  for (std::size_t v = 0; v < tangents.size(); ++v, out += sizeof(Vec4f)) {
    Vec4f stored = tangents[v];
    if (Vec3d t{stored.x, stored.y, stored.z}; !is_unit(t)) {
      if (!normalise(t)) {
        const bool have = v < fragment.attributes.normals.size();
        t = perpendicular_to(have ? to_double(fragment.attributes.normals[v]) : Vec3d{0, 0, 1});
      }
      const Vec3f f = to_float(t);
      stored.x = f.x, stored.y = f.y, stored.z = f.z;
    }
    stored.w = stored.w < 0 ? -1.0f : 1.0f;
    std::memcpy(out, &stored, sizeof(Vec4f));
  }
}

void append_uvs(ViewBytes& view, const std::vector<Vec2f>& uvs) { append_raw(view, uvs); }

void append_colors(ViewBytes& view, const std::vector<Vec4f>& colors) {
  std::uint8_t* out = view.extend(colors.size() * sizeof(Vec4f));
  const auto unit = [](float c) { return std::clamp(c, 0.0f, 1.0f); };
  for (const Vec4f& c : colors) {
    const Vec4f stored{unit(c.x), unit(c.y), unit(c.z), unit(c.w)};
    std::memcpy(out, &stored, sizeof(Vec4f));
    out += sizeof(Vec4f);
  }
}

}  // namespace fracture
