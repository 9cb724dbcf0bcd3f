#include "common/gltf/vertex_data.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace fracture {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little-endian");

constexpr std::size_t kLeastChunk = 1 << 16, kMostChunk = 1 << 22;  // bytes
constexpr std::size_t kBlock = 4096;                                // values between two polls

template <class Vec>
void append_raw(ViewBytes& view, const std::vector<Vec>& values) {
  view.append(values.data(), values.size() * sizeof(Vec));
}

/// Appends stored(value, its index) for each value.
template <class Vec, class Stored>
void append_each(ViewBytes& view, const std::vector<Vec>& values, const Stored& stored) {
  for (std::size_t begin = 0; begin < values.size(); begin += kBlock) {
    const std::size_t end = std::min(values.size(), begin + kBlock);
    std::uint8_t* out = view.extend((end - begin) * sizeof(Vec));
    for (std::size_t v = begin; v < end; ++v, out += sizeof(Vec)) {
      const Vec value = stored(values[v], v);
      std::memcpy(out, &value, sizeof(Vec));
    }
  }
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

/// For vertices without a normal: the direction of the first triangle at each that has one. Found for all of
/// them at once, when the first is asked about.
class TriangleNormals {
 public:
  TriangleNormals(const Fragment& fragment, Pacer& pacer) : fragment_(fragment), pacer_(pacer) {}

  Vec3d at(std::size_t vertex) {
    if (first_.empty()) find();
    Vec3d n;
    return first_[vertex] != kNoIndex && direction(first_[vertex], n) ? n : Vec3d{0, 0, 1};
  }

 private:
  bool direction(std::size_t k, Vec3d& n) const {
    const std::uint32_t* i = &fragment_.indices[k];
    const Vec3d a = to_double(fragment_.positions[i[0]]);
    n = cross(to_double(fragment_.positions[i[1]]) - a, to_double(fragment_.positions[i[2]]) - a);
    return normalise(n);
  }
  void find() {
    first_.assign(fragment_.positions.size(), kNoIndex);
    Vec3d n;
    for (std::size_t k = 0; k + 2 < fragment_.indices.size(); k += 3) {
      pacer_.step();
      if (!direction(k, n)) continue;
      for (std::size_t c = k; c < k + 3; ++c)
        first_[fragment_.indices[c]] = std::min(first_[fragment_.indices[c]], static_cast<std::uint32_t>(k));
    }
  }

  const Fragment& fragment_;
  Pacer& pacer_;
  std::vector<std::uint32_t> first_;  // per vertex: where in the indices that triangle begins
};

Vec3d perpendicular_to(const Vec3d& n) {
  Vec3d t = std::abs(n.x) < 0.5 ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0});
  return normalise(t) ? t : Vec3d{1, 0, 0};
}

}  // namespace

void ViewBytes::add_chunk(std::size_t least) {
  chunks_.emplace_back();
  chunks_.back().reserve(std::max(least, std::clamp(size_, kLeastChunk, kMostChunk)));
}

void ViewBytes::append(const void* bytes, std::size_t count) {
  const auto* from = static_cast<const std::uint8_t*>(bytes);
  for (std::size_t size; count > 0; count -= size, from += size) {
    size = std::min(count, kLeastChunk);
    std::memcpy(extend(size), from, size);
  }
}

void append_positions(ViewBytes& view, const std::vector<Vec3f>& positions, Vec3f& min, Vec3f& max) {
  append_raw(view, positions);
  min = max = positions.front();
  for (std::size_t begin = 0; begin < positions.size(); begin += kBlock) {
    const std::size_t end = std::min(positions.size(), begin + kBlock);
    view.pacer().step((end - begin) / 8);
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3f& p = positions[v];
      min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
      max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
    }
  }
}

void append_normals(ViewBytes& view, const Fragment& fragment) {
  TriangleNormals of_triangles(fragment, view.pacer());
  append_each(view, fragment.attributes.normals, [&](const Vec3f& normal, std::size_t v) {
    Vec3d n = to_double(normal);
    if (is_unit(n)) return normal;
    if (!normalise(n)) n = of_triangles.at(v);
    return to_float(n);
  });
}

void append_tangents(ViewBytes& view, const Fragment& fragment) {
  append_each(view, fragment.attributes.tangents, [&](const Vec4f& tangent, std::size_t v) {
    Vec4f stored = tangent;
    if (Vec3d t{stored.x, stored.y, stored.z}; !is_unit(t)) {
      if (!normalise(t)) {
        const bool have = v < fragment.attributes.normals.size();
        t = perpendicular_to(have ? to_double(fragment.attributes.normals[v]) : Vec3d{0, 0, 1});
      }
      const Vec3f f = to_float(t);
      stored.x = f.x, stored.y = f.y, stored.z = f.z;
    }
    stored.w = stored.w < 0 ? -1.0f : 1.0f;
    return stored;
  });
}

void append_uvs(ViewBytes& view, const std::vector<Vec2f>& uvs) { append_raw(view, uvs); }

void append_colors(ViewBytes& view, const std::vector<Vec4f>& colors) {
  const auto unit = [](float c) { return std::clamp(c, 0.0f, 1.0f); };
  append_each(view, colors, [&](const Vec4f& c, std::size_t) {
    return Vec4f{unit(c.x), unit(c.y), unit(c.z), unit(c.w)};
  });
}

}  // namespace fracture
