#include "common/base/cell_map.hpp"

#include "common/base/long_axis.hpp"

namespace fracture {

std::optional<Vec3d> grain_under(const Matrix3& map) {
  constexpr double kLonger = 1.4;               // minimum length / next length; cells with less have no grain
  Matrix3 square{{Vec3d{}, Vec3d{}, Vec3d{}}};  // its eigenvalues are 1 / (length of a cell)²
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (const Vec3d& row : map.rows) square.rows[static_cast<std::size_t>(i)][j] += row[i] * row[j];
  const std::optional<ShortAxis> least = short_axis(square);
  if (!least || least->ratio * kLonger * kLonger > 1) return std::nullopt;
  return least->axis;
}

CellMap::CellMap(std::span<const Matrix3> matrices, std::vector<std::uint8_t> frame_of_part,
                 std::span<const Box> boxes) {
  double diagonal = 0;
  for (const Box& box : boxes)
    if (!box.empty()) diagonal = std::fmax(diagonal, length(box.size()));
  // A power of two at which two boxes are farther apart than any two points of one box. Sites are multiples
  // of a power of two, so they are shifted without rounding.
  int exponent = 0;
  std::frexp(2.01 * diagonal, &exponent);  // the margin of 0.01 covers the rounding of middles to steps
  pitch_ = std::ldexp(1.0, exponent);
  const double step = pitch_ / 4096;
  for (std::size_t k = 0; k < matrices.size(); ++k) {
    Frame frame{.matrix = matrices[k]};
    const Vec3d middle = boxes[k].empty() ? Vec3d{} : boxes[k].center();
    for (int axis = 0; axis < 3; ++axis)
      frame.shift[axis] =
          pitch_ * static_cast<double>(k >> axis & 1) - step * std::nearbyint(middle[axis] / step);
    frames_.push_back(frame);
    places_.push_back({boxes[k].min + frame.shift, boxes[k].max + frame.shift});
  }
  if (frames_.size() > 1)
    frame_of_part_ =
        std::make_shared<const std::vector<std::uint16_t>>(frame_of_part.begin(), frame_of_part.end());
}

CellMap CellMap::joined(std::span<const CellMap> maps, std::span<const std::uint32_t> map_of_part,
                        std::span<const std::uint32_t> in_map) {
  CellMap all;
  std::vector<std::size_t> first;  // frame of each map
  for (const CellMap& map : maps) {
    first.push_back(all.frames_.size());
    if (!map) all.frames_.emplace_back();
    all.frames_.insert(all.frames_.end(), map.frames_.begin(), map.frames_.end());
  }
  std::vector<std::uint16_t> frame_of_part(map_of_part.size());
  for (std::size_t p = 0; p < frame_of_part.size(); ++p) {
    const CellMap& map = maps[map_of_part[p]];
    const auto frame = map ? &map.of_part(in_map[p]) - map.frames_.data() : 0;
    frame_of_part[p] = static_cast<std::uint16_t>(first[map_of_part[p]] + static_cast<std::size_t>(frame));
  }
  all.frame_of_part_ = std::make_shared<const std::vector<std::uint16_t>>(std::move(frame_of_part));
  return all;
}

}  // namespace fracture
