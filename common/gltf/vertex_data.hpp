// Writes a mesh's arrays as the file stores them: float32, one bufferView for each attribute, and 16-bit or 32-bit indices.
// They are strictly valid: unit normals and tangents, handedness exactly +1 or -1, colours in [0, 1].
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/fragments.hpp"
#include "common/gltf/interior_material.hpp"

namespace fracture {

struct Bounds {
  Vec3f min, max;
};
/// Returns the bounds of at least one position. Throws Interrupted.
Bounds bounds_of(const std::vector<Vec3f>& positions, Pacer& pacer);

/// Texture coordinates of a fragment. Those of its cuts are moved to the place of their material's picture.
struct MovedUvs {
  const Fragment& fragment;
  std::size_t set;
  CutUvs to;
};

// Functions for BufferContents::put(). All of them fill `out` and throw Interrupted.

using Room = std::span<std::uint8_t>;
/// Copies as many bytes as `out` has, beginning with `first`.
void write_bytes(const std::uint8_t& first, Room out, Pacer& pacer);
void write_positions(const std::vector<Vec3f>& positions, Room out, Pacer& pacer);
/// Unit normals keep their bits; others are normalised. A zero normal becomes the normal of the first triangle
/// at its vertex that has one.
void write_normals(const Fragment& fragment, Room out, Pacer& pacer);
/// Like write_normals(), but a zero tangent becomes any direction perpendicular to the vertex normal.
void write_tangents(const Fragment& fragment, Room out, Pacer& pacer);
/// Normals and tangents for cuts if the source has none. A normal is the mean of the cut triangles at the vertex, weighted
/// by area; a tangent is the direction in which u grows. Vertices of the outside get arbitrary values.
void write_cut_normals(const Fragment& fragment, Room out, Pacer& pacer);
void write_cut_tangents(const Fragment& fragment, Room out, Pacer& pacer);
void write_uvs(const std::vector<Vec2f>& uvs, Room out, Pacer& pacer);
void write_moved_uvs(const MovedUvs& uvs, Room out, Pacer& pacer);
void write_colors(const std::vector<Vec4f>& colors, Room out, Pacer& pacer);
void write_short_indices(const std::vector<std::uint32_t>& indices, Room out, Pacer& pacer);
void write_long_indices(const std::vector<std::uint32_t>& indices, Room out, Pacer& pacer);
void write_short_triangles(const std::vector<std::array<std::uint32_t, 3>>& triangles, Room out,
                           Pacer& pacer);

}  // namespace fracture
