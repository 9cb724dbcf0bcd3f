// Vertex attributes as the file stores them: float32, one bufferView for each attribute, valid by the letter
// of the specification (unit normals and tangents, handedness exactly +1 or -1, colours in [0, 1]).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/pacer.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// A growing bufferView's worth of bytes, in chunks: nothing is moved while it grows, however large it gets,
/// and no step takes longer than a chunk.
class ViewBytes {
 public:
  /// Borrowed.
  explicit ViewBytes(const Execution& execution) : pacer_(execution) {}

  std::size_t size() const { return size_; }
  /// Room for `count` bytes in one piece at the end. Throws Interrupted.
  std::uint8_t* extend(std::size_t count) {
    pacer_.step(count / 64);
    if (chunks_.empty() || chunks_.back().capacity() - chunks_.back().size() < count) add_chunk(count);
    std::vector<std::uint8_t>& chunk = chunks_.back();
    chunk.resize(chunk.size() + count);
    size_ += count;
    return chunk.data() + chunk.size() - count;
  }
  /// Throws Interrupted.
  void append(const void* bytes, std::size_t count);
  void align(std::size_t to) {
    if (size_ % to != 0) extend(to - size_ % to);  // zeros
  }

  /// Of whoever fills it, for what it does besides.
  Pacer& pacer() { return pacer_; }
  /// One after the other they are the view. A chunk that is not needed any more may be emptied.
  std::vector<std::vector<std::uint8_t>>& chunks() { return chunks_; }

 private:
  void add_chunk(std::size_t least);

  Pacer pacer_;
  std::vector<std::vector<std::uint8_t>> chunks_;
  std::size_t size_ = 0;
};

/// All of them throw Interrupted.
void append_positions(ViewBytes& view, const std::vector<Vec3f>& positions, Vec3f& min, Vec3f& max);
/// Normals that are unit keep their bits, others are normalised; one without direction takes that of the
/// first triangle at it that has one.
void append_normals(ViewBytes& view, const Fragment& fragment);
/// As normals; one without direction takes any that is perpendicular to the vertex normal.
void append_tangents(ViewBytes& view, const Fragment& fragment);
void append_uvs(ViewBytes& view, const std::vector<Vec2f>& uvs);
void append_colors(ViewBytes& view, const std::vector<Vec4f>& colors);

}  // namespace fracture
