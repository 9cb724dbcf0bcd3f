#include "common/contacts/part_boxes.hpp"

#include "common/base/long_axis.hpp"
#include "common/base/matrix3.hpp"

namespace fracture::contacts_detail {
namespace {

/// Rotated boxes must be smaller by this factor to be worth their cost.
constexpr double kWorthwhile = 0.75;

/// Returns Σ area · n nᵀ over the triangles, up to a factor.
Matrix3 spread_of_normals(const Solid& solid, Pacer& pacer) {
  Matrix3 spread{{Vec3d{}, Vec3d{}, Vec3d{}}};
  pacer.each(0, solid.triangles.size(), [&](std::size_t t) {
    const auto& v = solid.triangles[t];
    const Vec3d p = to_double(solid.positions[v[0]]);
    const Vec3d across = cross(to_double(solid.positions[v[1]]) - p, to_double(solid.positions[v[2]]) - p);
    const double size = length(across);
    if (!(size > 0)) return;
    const Vec3d share = (1 / size) * across;
    spread.rows[0] = spread.rows[0] + across.x * share;
    spread.rows[1] = spread.rows[1] + across.y * share;
    spread.rows[2] = spread.rows[2] + across.z * share;
  });
  return spread;
}

/// Returns three orthogonal directions. The first is the one in which the least surface faces (along
/// boards); the second is nearest to the one in which the most does.
std::optional<Matrix3> frame_of(const Matrix3& spread) {
  const auto least = short_axis(spread);
  const auto most = long_axis(spread);
  if (!least || !most) return std::nullopt;
  const Vec3d across = most->axis - dot(most->axis, least->axis) * least->axis;
  const double size = length(across);
  if (!(size > 0.5)) return std::nullopt;
  const Vec3d second = (1 / size) * across;
  return Matrix3{{least->axis, second, cross(least->axis, second)}};
}

double surface_of(const Box& box) {
  const Vec3d s = box.size();
  return s.x * s.y + s.y * s.z + s.z * s.x;
}

std::vector<Box> boxes_along(const Matrix3& frame, const Solid& solid, Pacer& pacer) {
  std::vector<Box> boxes(solid.parts.size());
  pacer.each(0, solid.triangles.size(), [&](std::size_t t) {
    for (const VertexId v : solid.triangles[t])
      boxes[solid.part[t]].add(frame * to_double(solid.positions[v]));
  });
  return boxes;
}

/// Returns boxes in the frame above; empty if these are not smaller than axis-aligned ones.
std::vector<Box> turned_boxes(const Solid& solid, const Execution& execution) {
  Pacer pacer(execution);
  const auto frame = frame_of(spread_of_normals(solid, pacer));
  if (!frame) return {};
  double straight = 0, turned = 0;
  std::vector<Box> boxes = boxes_along(*frame, solid, pacer);
  for (std::size_t p = 0; p < boxes.size(); ++p) {
    straight += surface_of(solid.parts[p].box);
    turned += surface_of(boxes[p]);
  }
  if (turned < kWorthwhile * straight) return boxes;
  return {};
}

std::vector<Box> straight_boxes(const Solid& solid, const Execution& execution) {
  Pacer pacer(execution);
  std::vector<Box> boxes;
  boxes.reserve(solid.parts.size());
  pacer.each(0, solid.parts.size(), [&](std::size_t p) { boxes.push_back(solid.parts[p].box); });
  return boxes;
}

}  // namespace

PartBoxes::PartBoxes(const Solid& solid, double reach, const Execution& execution)
    : solid_(solid),
      reach_(reach),
      turned_(turned_boxes(solid, execution)),
      tree_(turned_.empty() ? straight_boxes(solid, execution) : turned_, execution) {}

}  // namespace fracture::contacts_detail
