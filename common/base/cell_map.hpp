// The map under which cells are those of the nearest site: from the frame of a solid to its image, where it is decided
// how the solid is cut (solid/image.hpp). One linear map for all of it, or several, so that each part of the solid has
// a grain of its own: then each has a place of its own in the image, so far from the others that what lies in one is
// always nearest to a site in the same.
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

/// The direction of unit length, of either sign, in which the cells of a map are by far the longest; none where none is.
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
  /// One bit of a frame's number for each axis says where its place is.
  static constexpr std::size_t kMostFrames = 8;

  /// The identity.
  CellMap() = default;
  /// The same for all parts. Of positive determinant.
  CellMap(const Matrix3& matrix) : frames_{{.matrix = matrix}} {}  // NOLINT: a matrix is a map
  /// `matrices[k]`, up to kMostFrames and of one determinant, for the parts with frame_of_part[p] == k, whose images
  /// under it are in boxes[k].
  CellMap(std::span<const Matrix3> matrices, std::vector<std::uint8_t> frame_of_part,
          std::span<const Box> boxes);

  /// Whether it is not the identity.
  explicit operator bool() const { return !frames_.empty(); }
  std::span<const Frame> frames() const { return frames_; }
  /// Of a part of the solid. Not of the identity.
  const Frame& of_part(std::uint32_t part) const {
    return frames_[frame_of_part_ ? (*frame_of_part_)[part] : 0];
  }
  /// The number of the frame in whose place a point of the image lies.
  std::size_t index_at(const Vec3d& image) const {
    if (frames_.size() < 2) return 0;
    std::size_t index = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (image[static_cast<int>(axis)] > pitch_ / 2) index |= std::size_t{1} << axis;
    return std::min(index, frames_.size() - 1);
  }
  const Frame& at(const Vec3d& image) const { return frames_[index_at(image)]; }
  /// Where in the image the parts of a frame are, but for rounding; of a single one everything.
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
  double pitch_ = 0;                                                ///< between the middles of two places
  std::shared_ptr<const std::vector<std::uint8_t>> frame_of_part_;  ///< null: all in the first
};

}  // namespace fracture
