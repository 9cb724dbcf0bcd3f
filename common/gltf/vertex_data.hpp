// Vertex attributes as the file stores them: float32, one bufferView for each attribute, valid by the letter
// of the specification (unit normals and tangents, handedness exactly +1 or -1, colours in [0, 1]).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/fragment/fragments.hpp"

namespace fracture {

/// A growing bufferView's worth of bytes.
class ViewBytes {
 public:
  std::size_t size() const { return bytes_.size(); }
  const std::uint8_t* data() const { return bytes_.data(); }
  /// Room for `count` bytes at the end.
  std::uint8_t* extend(std::size_t count) {
    bytes_.resize(bytes_.size() + count);
    return bytes_.data() + bytes_.size() - count;
  }
  void reserve(std::size_t count) { bytes_.reserve(count); }
  void align(std::size_t to) { bytes_.resize((bytes_.size() + to - 1) / to * to); }

 private:
  std::vector<std::uint8_t> bytes_;
};

void append_positions(ViewBytes& view, const std::vector<Vec3f>& positions, Vec3f& min, Vec3f& max);
/// Normals that are unit keep their bits, others are normalised; one without direction takes that of a
/// triangle at it.
void append_normals(ViewBytes& view, const Fragment& fragment);
/// As normals; one without direction takes any that is perpendicular to the vertex normal.
void append_tangents(ViewBytes& view, const Fragment& fragment);
void append_uvs(ViewBytes& view, const std::vector<Vec2f>& uvs);
void append_colors(ViewBytes& view, const std::vector<Vec4f>& colors);

}  // namespace fracture
