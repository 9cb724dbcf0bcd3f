// The map under which cells belong to the nearest site: from the frame of a solid to its image, in which the
// cuts are computed (solid/image.hpp). There is one linear map for the whole solid, or there are several, so
// that each part can have its own grain. With several, each map (a frame) has its own place in the image. The
// places are so far apart that every point is nearest to a site in the same place.
//
//     solid                  image, with two frames
//     ┌──────────┐           ┌─────┐                  ┌──┐
//     │    ║     │    ──>    │     │                  ║  ║
//     │    ║     │           └─────┘ ···· pitch ····> └──┘
//     └──────────┘
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/base/matrix3.hpp"
#include "common/base/vec.hpp"

namespace fracture {

/// The unit direction (of either sign) in which the cells of a map are much longer than in others; none if
/// there is none.
std::optional<Vec3d> grain_under(const Matrix3& map);

class CellMap {
 public:
  struct Frame {
    Matrix3 matrix{};
    Vec3d shift{};
    Matrix3 inverse = matrix.inverse();
    std::optional<Vec3d> grain = grain_under(matrix);
    Vec3d image(const Vec3d& place) const { return matrix * place + shift; }
    Vec3d place(const Vec3d& image) const { return inverse * (image - shift); }
    friend bool operator==(const Frame&, const Frame&) = default;
  };
  /// Each bit of a frame's number selects its place along one axis.
  static constexpr std::size_t kMostFrames = 8;

  /// The identity.
  CellMap() = default;
  /// The same map for all parts. Its determinant must be positive.
  CellMap(const Matrix3& matrix) : frames_{{.matrix = matrix}} {}  // NOLINT: a matrix is a map
  /// Several maps: `matrices[k]` applies to the parts p with frame_of_part[p] == k, and boxes[k] contains
  /// their images under it. At most kMostFrames matrices, with equal determinants.
  CellMap(std::span<const Matrix3> matrices, std::vector<std::uint8_t> frame_of_part,
          std::span<const Box> boxes);
  /// The maps of separate diagrams as one, for code that asks only for the frame of a part: at(), index_at() and place_of() have
  /// no meaning. Part p is the part `in_map[p]` of maps[`map_of_part[p]`]. An identity becomes a frame. At most 65,535 frames.
  static CellMap joined(std::span<const CellMap> maps, std::span<const std::uint32_t> map_of_part,
                        std::span<const std::uint32_t> in_map);

  /// Whether it is not the identity.
  explicit operator bool() const { return !frames_.empty(); }
  std::span<const Frame> frames() const { return frames_; }
  /// The frame of a part of the solid. Must not be called on the identity.
  const Frame& of_part(std::uint32_t part) const {
    return frames_[frame_of_part_ ? (*frame_of_part_)[part] : 0];
  }
  /// The same map for a solid of `count` parts, of which the first ones are those of this map. Further parts have the first
  /// frame. In a joined map, they have a copy of it, because their cells may be those of several diagrams.
  CellMap with_parts(std::size_t count) const {
    CellMap map = *this;
    if (!frame_of_part_) return map;
    std::vector<std::uint16_t> frames = *frame_of_part_;
    if (places_.empty()) map.frames_.push_back(frames_.front());
    frames.resize(count, static_cast<std::uint16_t>(places_.empty() ? frames_.size() : 0));
    map.frame_of_part_ = std::make_shared<const std::vector<std::uint16_t>>(std::move(frames));
    return map;
  }
  /// Index of the frame whose place contains a point of the image.
  std::size_t index_at(const Vec3d& image) const {
    if (frames_.size() < 2) return 0;
    std::size_t index = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (image[static_cast<int>(axis)] > pitch_ / 2) index |= std::size_t{1} << axis;
    return std::min(index, frames_.size() - 1);
  }
  const Frame& at(const Vec3d& image) const { return frames_[index_at(image)]; }
  /// The box of a frame's parts in the image, up to rounding; everything if there is a single frame.
  Box place_of(std::size_t frame) const {
    constexpr double kFar = HUGE_VAL;
    return frames_.size() < 2 ? Box{{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}} : places_[frame];
  }

  friend bool operator==(const CellMap& a, const CellMap& b) {
    return a.frames_ == b.frames_ && a.pitch_ == b.pitch_ &&
           (a.frame_of_part_ == b.frame_of_part_ ||
            (a.frame_of_part_ && b.frame_of_part_ && *a.frame_of_part_ == *b.frame_of_part_));
  }

 private:
  std::vector<Frame> frames_;
  std::vector<Box> places_;
  double pitch_ = 0;  ///< distance between neighbouring middles
  std::shared_ptr<const std::vector<std::uint16_t>> frame_of_part_;  ///< null: all parts in the first frame
};

}  // namespace fracture
