#include "common/gltf/vertex_data.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "common/solid/cut_materials.hpp"

namespace fracture {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little-endian");

constexpr std::size_t kBlock = 4096;  // values between two polls

template <class Value>
void write_raw(const std::vector<Value>& values, Room out, Pacer& pacer) {
  write_bytes(*reinterpret_cast<const std::uint8_t*>(values.data()), out, pacer);
}

/// Writes stored(value, its index) for each value.
template <class Value, class Stored>
void write_each(std::span<const Value> values, Room out, Pacer& pacer, const Stored& stored) {
  std::uint8_t* to = out.data();
  for (std::size_t begin = 0; begin < values.size(); begin += kBlock) {
    const std::size_t end = std::min(values.size(), begin + kBlock);
    pacer.step((end - begin) / 4);
    for (std::size_t v = begin; v < end; ++v) {
      const auto value = stored(values[v], v);
      std::memcpy(to, &value, sizeof(value));
      to += sizeof(value);
    }
  }
}

std::uint16_t narrow(std::uint32_t index, std::size_t) { return static_cast<std::uint16_t>(index); }

/// The tolerance is well below that of validators, and well above the rounding of three floats.
bool is_unit(const Vec3d& v) { return std::abs(dot(v, v) - 1) < 1e-5; }

/// Scales v to unit length. Returns false if v has no direction. A product of edges of the smallest floats is
/// about 1e-90, whose square does not underflow.
bool normalise(Vec3d& v) {
  const double l = length(v);
  if (!(l > 0) || !std::isfinite(l)) return false;
  v = {v.x / l, v.y / l, v.z / l};
  return true;
}

Vec3f to_float(const Vec3d& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Replaces missing normals: a vertex gets the normal of the first triangle at it that has one. The first call
/// of at() finds these triangles for all vertices.
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
  std::vector<std::uint32_t> first_;  // per vertex: position of that triangle in the indices
};

Vec3d perpendicular_to(const Vec3d& n) {
  Vec3d t = std::abs(n.x) < 0.5 ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0});
  return normalise(t) ? t : Vec3d{1, 0, 0};
}

/// Computes normals and tangents of cuts from their positions and texture coordinates only.
class CutFrames {
 public:
  CutFrames(const Fragment& fragment, Pacer& pacer)
      : fragment_(fragment), normals_(fragment.positions.size()), right_(fragment.positions.size()) {
    for (const FragmentPrimitive& p : fragment.primitives) {
      if (!is_of_cuts(p.material)) continue;
      for (std::uint32_t k = p.first_index; k < p.first_index + p.index_count; k += 3) {
        pacer.step(2);
        add(&fragment.indices[k]);
      }
    }
  }
  /// Returns the fragment's own normal if it has normals.
  Vec3d normal(std::size_t v) const {
    Vec3d n = fragment_.attributes.normals.empty() ? normals_[v] : to_double(fragment_.attributes.normals[v]);
    return normalise(n) ? n : Vec3d{0, 0, 1};
  }
  Vec3d tangent(std::size_t v) const {
    const Vec3d n = normal(v);
    Vec3d t = right_[v] - dot(n, right_[v]) * n;
    return normalise(t) ? t : perpendicular_to(n);
  }

 private:
  void add(const std::uint32_t* corners) {
    const auto at = [&](std::size_t c) { return to_double(fragment_.positions[corners[c]]); };
    const Vec3d e1 = at(1) - at(0), e2 = at(2) - at(0), n = cross(e1, e2);
    Vec3d right;
    if (!fragment_.attributes.uvs.empty()) {
      const std::vector<Vec2f>& uvs = fragment_.attributes.uvs[0];  // cuts have planar UVs in every set
      const double v0 = uvs[corners[0]].y, v1 = uvs[corners[1]].y - v0, v2 = uvs[corners[2]].y - v0;
      const double u0 = uvs[corners[0]].x, u1 = uvs[corners[1]].x - u0, u2 = uvs[corners[2]].x - u0;
      right = (u1 * v2 < u2 * v1 ? -1.0 : 1.0) * (v2 * e1 - v1 * e2);
      right = normalise(right) ? length(n) * right : Vec3d{};
    }
    for (std::size_t c = 0; c < 3; ++c) {
      normals_[corners[c]] = normals_[corners[c]] + n;
      right_[corners[c]] = right_[corners[c]] + right;
    }
  }

  const Fragment& fragment_;
  std::vector<Vec3d> normals_, right_;  // sums, per vertex
};

}  // namespace

Bounds bounds_of(const std::vector<Vec3f>& positions, Pacer& pacer) {
  Vec3f min = positions.front(), max = min;
  pacer.each(0, positions.size(), [&](std::size_t v) {
    const Vec3f& p = positions[v];
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  });
  return {min, max};
}

void write_bytes(const std::uint8_t& first, Room out, Pacer& pacer) {
  const std::uint8_t* from = &first;
  for (std::size_t at = 0; at < out.size(); at += kBytesBetweenPolls) {
    const std::size_t size = std::min(out.size() - at, kBytesBetweenPolls);
    pacer.step(size / 64);
    std::memcpy(&out[at], from + at, size);
  }
}

void write_positions(const std::vector<Vec3f>& positions, Room out, Pacer& pacer) {
  write_raw(positions, out, pacer);
}

void write_normals(const Fragment& fragment, Room out, Pacer& pacer) {
  TriangleNormals of_triangles(fragment, pacer);
  write_each(std::span(fragment.attributes.normals), out, pacer, [&](const Vec3f& normal, std::size_t v) {
    Vec3d n = to_double(normal);
    if (is_unit(n)) return normal;
    if (!normalise(n)) n = of_triangles.at(v);
    return to_float(n);
  });
}

void write_tangents(const Fragment& fragment, Room out, Pacer& pacer) {
  write_each(std::span(fragment.attributes.tangents), out, pacer, [&](const Vec4f& tangent, std::size_t v) {
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

void write_cut_normals(const Fragment& fragment, Room out, Pacer& pacer) {
  const CutFrames frames(fragment, pacer);
  write_each(std::span(fragment.positions), out, pacer,
             [&](const Vec3f&, std::size_t v) { return to_float(frames.normal(v)); });
}

void write_cut_tangents(const Fragment& fragment, Room out, Pacer& pacer) {
  const CutFrames frames(fragment, pacer);
  write_each(std::span(fragment.positions), out, pacer, [&](const Vec3f&, std::size_t v) {
    const Vec3f t = to_float(frames.tangent(v));
    return Vec4f{t.x, t.y, t.z, 1};  // the same handedness as for cuts of a source with tangents
  });
}

void write_uvs(const std::vector<Vec2f>& uvs, Room out, Pacer& pacer) { write_raw(uvs, out, pacer); }

void write_moved_uvs(const MovedUvs& moved, Room out, Pacer& pacer) {
  const Fragment& f = moved.fragment;
  const std::vector<Vec2f>& uvs = f.attributes.uvs[moved.set];
  write_uvs(uvs, out, pacer);
  for (const FragmentPrimitive& p : f.primitives) {
    if (!is_of_cuts(p.material)) continue;
    pacer.each(p.first_index, p.first_index + p.index_count, [&](std::size_t k) {
      const std::uint32_t vertex = f.indices[k];  // used by cut faces only: the outside has separate vertices
      const Vec2f uv{static_cast<float>(moved.to.scale * uvs[vertex].x + moved.to.u),
                     static_cast<float>(moved.to.scale * uvs[vertex].y + moved.to.v)};
      std::memcpy(&out[vertex * sizeof(uv)], &uv, sizeof(uv));
    });
  }
}

void write_colors(const std::vector<Vec4f>& colors, Room out, Pacer& pacer) {
  const auto unit = [](float c) { return std::clamp(c, 0.0f, 1.0f); };
  write_each(std::span(colors), out, pacer, [&](const Vec4f& c, std::size_t) {
    return Vec4f{unit(c.x), unit(c.y), unit(c.z), unit(c.w)};
  });
}

void write_short_indices(const std::vector<std::uint32_t>& indices, Room out, Pacer& pacer) {
  write_each(std::span(indices), out, pacer, narrow);
}

void write_long_indices(const std::vector<std::uint32_t>& indices, Room out, Pacer& pacer) {
  write_raw(indices, out, pacer);
}

void write_short_triangles(const std::vector<std::array<std::uint32_t, 3>>& triangles, Room out,
                           Pacer& pacer) {
  write_each(std::span(triangles.front().data(), 3 * triangles.size()), out, pacer, narrow);
}

}  // namespace fracture
