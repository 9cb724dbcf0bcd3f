// Arrays of a mesh as the file stores them: float32, one bufferView for each attribute, valid by the letter of the
// specification (unit normals and tangents, handedness exactly +1 or -1, colours in [0, 1]); indices of 16 or 32 bits.
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
/// Of one position or more. Throws Interrupted.
Bounds bounds_of(const std::vector<Vec3f>& positions, Pacer& pacer);

/// Texture coordinates of a fragment of which those of its cuts are moved to where their material has its picture.
struct MovedUvs {
  const Fragment& fragment;
  std::size_t set;
  CutUvs to;
};

// For BufferContents::put(): all of them write the whole of `out` and throw Interrupted.

using Room = std::span<std::uint8_t>;
/// As many bytes as there is room for, from `first` on.
void write_bytes(const std::uint8_t& first, Room out, Pacer& pacer);
void write_positions(const std::vector<Vec3f>& positions, Room out, Pacer& pacer);
/// Normals that are unit keep their bits, others are normalised; one without direction takes that of the
/// first triangle at it that has one.
void write_normals(const Fragment& fragment, Room out, Pacer& pacer);
/// As normals; one without direction takes any that is perpendicular to the vertex normal.
void write_tangents(const Fragment& fragment, Room out, Pacer& pacer);
/// Normals and tangents for the cuts of a fragment whose source has none: the mean of the triangles of cuts at each
/// vertex by their area, and the direction of growing u across it. Vertices of the outside get any.
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
