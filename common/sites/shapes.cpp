#include "common/sites/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/base/long_axis.hpp"
#include "common/base/pacer.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/moments.hpp"

namespace fracture {
namespace {

using sites_detail::Moments;

constexpr double kPlate = 0.2;  // maximum thickness / width
constexpr double kRod = 4;      // minimum length / width

/// Chooses the sign that makes the largest component positive.
Vec3d with_sign(const Vec3d& axis) {
  int largest = 0;
  for (const int k : {1, 2})
    if (std::fabs(axis[k]) > std::fabs(axis[largest])) largest = k;
  return axis[largest] < 0 ? -1.0 * axis : axis;
}

std::optional<Vec3d> thin_axis(const Moments& moments) {
  if (!(moments.volume > 0)) return std::nullopt;
  const std::optional<ShortAxis> shortest = short_axis(moments.central());
  if (!shortest || !(shortest->ratio <= kPlate * kPlate)) return std::nullopt;
  return with_sign(sites_detail::without_noise(shortest->axis));
}

/// Shape of a part from its moments about the middle of its box. Does not set where a rod begins and ends.
PartShape shape_of(const Moments& moments, const Box& box) {
  PartShape shape;
  const Vec3d origin = box.center();
  shape.middle = origin;
  if (!(moments.volume > 0)) return shape;
  // If the surface crosses itself, the computed centre may be anywhere.
  const Vec3d middle = origin + (1 / moments.volume) * moments.first;
  for (int k = 0; k < 3; ++k) shape.middle[k] = std::fmin(std::fmax(middle[k], box.min[k]), box.max[k]);
  if (length(shape.middle - middle) > 0) return shape;
  shape.thin = thin_axis(moments);
  const Matrix3 central = moments.central();
  const std::optional<LongAxis> longest = long_axis(central);
  if (!longest || !(longest->ratio >= kRod * kRod)) return shape;
  const Vec3d axis = with_sign(sites_detail::without_noise(longest->axis));
  const double trace = central.rows[0].x + central.rows[1].y + central.rows[2].z;
  const double across = 0.5 * (trace - dot(axis, central * axis));
  shape.rod = {axis, 0, 0, std::sqrt(12 * std::fmax(0, across) / moments.volume)};
  return shape;
}

/// Whether most of the volume is plates parallel to the whole, such as the panes of a window. False for
/// bottles on a table.
bool are_one_plate(const Solid& solid, const std::vector<PartShape>& of_part, const Execution& execution) {
  constexpr double kWithinTenDegrees = 0.985;
  const std::optional<Vec3d> thin = thin_axis(solid, execution);
  if (!thin) return false;
  double all = 0, along = 0;
  for (std::size_t p = 0; p < of_part.size(); ++p) {
    all += solid.parts[p].volume;
    if (of_part[p].thin && std::fabs(dot(*of_part[p].thin, *thin)) > kWithinTenDegrees)
      along += solid.parts[p].volume;
  }
  return along > 0.5 * all;
}

}  // namespace

std::optional<Vec3d> thin_axis(const Solid& solid, const Execution& execution) {
  const Vec3d origin = solid.box.center();
  Moments moments;
  Pacer pacer(execution);
  for (const auto& [a, b, c] : solid.triangles) {
    pacer.step(8);
    moments.add(to_double(solid.positions[a]) - origin, to_double(solid.positions[b]) - origin,
                to_double(solid.positions[c]) - origin);
  }
  return thin_axis(moments);
}

Shapes shapes_of(const Solid& solid, std::size_t most, const Execution& execution,
                 std::span<const double> sizes) {
  Shapes shapes;
  const std::size_t parts = solid.parts.size();
  if (parts < 2) return shapes;
  Pacer pacer(execution);
  std::vector<Moments> moments;
  resize_with_polls(execution, moments, parts);
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(8);
    // Take moments about the middle of the part's box, which is near enough to keep rounding errors small.
    const Vec3d origin = solid.parts[solid.part[t]].box.center();
    const auto& [a, b, c] = solid.triangles[t];
    moments[solid.part[t]].add(to_double(solid.positions[a]) - origin, to_double(solid.positions[b]) - origin,
                               to_double(solid.positions[c]) - origin);
  }
  for (std::size_t p = 0; p < parts; ++p) {
    pacer.step(16);
    shapes.of_part.push_back(shape_of(moments[p], solid.parts[p].box));
  }
  if (are_one_plate(solid, shapes.of_part, execution)) return {};
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    pacer.step(4);
    PartShape& shape = shapes.of_part[solid.part[t]];
    if (!shape.rod) continue;
    for (const VertexId v : solid.triangles[t]) {
      const double along = dot(to_double(solid.positions[v]) - shape.middle, shape.rod->axis);
      shape.rod->from = std::fmin(shape.rod->from, along);
      shape.rod->to = std::fmax(shape.rod->to, along);
    }
  }
  std::vector<std::uint32_t> order(parts);
  std::iota(order.begin(), order.end(), 0u);
  sort_with_polls(execution, order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    const double a = sizes.empty() ? solid.parts[x].volume : sizes[x];
    const double b = sizes.empty() ? solid.parts[y].volume : sizes[y];
    return a != b ? a > b : x < y;
  });
  shapes.frames = std::min(parts, most);
  resize_with_polls(execution, shapes.frame_of_part, parts);
  for (std::size_t k = 0; k < parts; ++k) {
    pacer.step();
    shapes.frame_of_part[order[k]] = static_cast<std::uint8_t>(std::min(k, shapes.frames - 1));
  }
  return shapes;
}

}  // namespace fracture
