#include "common/sites/request_places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/bvh/surface_tree.hpp"
#include "common/sites/column_sampler.hpp"

namespace fracture {
namespace {

/// The place of the root node, to which places of the solid are relative (SourceFrame::offset).
Vec3d root_of(const Solid& solid) { return solid.source ? solid.source->frame.offset : Vec3d{}; }

/// Returns a place as in the request. Short numbers are too short for places that are far from the origin.
std::string written(const Vec3d& p, const Vec3d& root) {
  if (root == Vec3d{}) return short_number(p.x) + "," + short_number(p.y) + "," + short_number(p.z);
  char text[96];
  std::snprintf(text, sizeof text, "%.10g,%.10g,%.10g", p.x + root.x, p.y + root.y, p.z + root.z);
  return text;
}

std::optional<std::string> likely_unit(const Vec3d& place, const Solid& solid) {
  const Vec3d root = root_of(solid);
  return likely_unit(place + root, Box{solid.box.min + root, solid.box.max + root});
}

/// The nearest point of the surface. If several triangles are equally near, that of the first one.
Vec3d nearest_place(const Solid& solid, const Vec3d& p, Pacer& pacer) {
  Vec3d nearest = p;
  double least = HUGE_VAL;
  for (const auto& [a, b, c] : solid.triangles) {
    pacer.step(2);
    const std::array<Vec3d, 3> corners{to_double(solid.positions[a]), to_double(solid.positions[b]),
                                       to_double(solid.positions[c])};
    if (square_distance(box_of(corners), p) >= least * least) continue;
    const Vec3d place = nearest_on_triangle(p, corners[0], corners[1], corners[2]);
    if (const double far = length(place - p); far < least) {
      least = far;
      nearest = place;
    }
  }
  return nearest;
}

/// Returns advice for a place outside the solid.
std::string correction_of(const Vec3d& place, const char* parameter, const Solid& solid) {
  const std::string name = std::string("'") + parameter + "'";
  const std::optional<std::string> unit = likely_unit(place, solid);
  return unit ? name + " is in metres, with y up, but " + written(place, root_of(solid)) + " looks like " +
                    *unit + ": convert it to metres."
              : "Move " + name + " onto the mesh; coordinates are in metres, with y up.";
}

void warn_of_moved(const Vec3d& from, const Vec3d& to, std::size_t others, const Solid& solid,
                   Remarks& remarks) {
  const Vec3d root = root_of(solid);
  remarks.warn(
      "The impact " + written(from, root) + " is outside the mesh, " + short_number(length(from - to)) +
      " m from its surface, so the nearest point of the surface is hit instead: " + written(to, root) + "." +
      (others == 0 ? std::string()
                   : " The same applies to " + counted(others, "further impact.", "further impacts.")) +
      " " + correction_of(from, "impacts", solid));
}

void move_onto(const Solid& solid, std::vector<Vec3d>& impacts, Remarks& remarks,
               const Execution& execution) {
  const std::vector<bool> inside = sites_detail::ColumnSampler(solid, 0, execution).inside(impacts);
  const double far = kFarFromSolid * solid.box.longest_side();
  Pacer pacer(execution);
  std::vector<std::pair<Vec3d, Vec3d>> moved;
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    if (inside[k]) continue;
    const Vec3d place = nearest_place(solid, impacts[k], pacer);
    if (!(length(place - impacts[k]) > far)) continue;
    moved.emplace_back(impacts[k], place);
    impacts[k] = place;
  }
  if (!moved.empty()) warn_of_moved(moved[0].first, moved[0].second, moved.size() - 1, solid, remarks);
}

Vec3d default_impact(const Solid& solid, Remarks& remarks, const Execution& execution) {
  const Vec3d middle = solid.box.center();
  if (sites_detail::ColumnSampler(solid, 0, execution).inside(std::span(&middle, 1))[0]) return middle;
  Pacer pacer(execution);
  const Vec3d place = nearest_place(solid, middle, pacer);
  remarks.note(
      "No impact point is set ('impacts'), and the centre of the mesh's bounding box is not inside the solid. So the "
      "mesh breaks around the nearest point of its surface: " +
      written(place, root_of(solid)) + ".");
  return place;
}

}  // namespace

std::span<const Vec3d> impacts_of(const SitePattern& pattern) {
  return std::visit(
      [](const auto& p) -> std::span<const Vec3d> {
        if constexpr (requires { p.impacts; })
          return p.impacts;
        else
          return {};
      },
      pattern);
}

void put_impacts_on(const Solid& solid, SitePattern& pattern, Remarks& remarks, const Execution& execution) {
  if (solid.triangles.empty()) return;
  std::visit(
      [&](auto& p) {
        if constexpr (requires { p.impacts; })
          if (!p.impacts.empty()) move_onto(solid, p.impacts, remarks, execution);
      },
      pattern);
  if (auto* impact = std::get_if<ImpactPattern>(&pattern); impact && impact->impacts.empty())
    impact->impacts.push_back(default_impact(solid, remarks, execution));
}

void check_points(const Solid& solid, const std::vector<Vec3d>& points, Remarks& remarks,
                  const Execution& execution) {
  if (points.empty() || solid.triangles.empty()) return;
  std::vector<Vec3d> sorted = points;
  sort_with_polls(execution, sorted.begin(), sorted.end(), lexicographic_less);
  const auto different = std::unique(sorted.begin(), sorted.end()) - sorted.begin();
  if (const std::size_t equal = points.size() - static_cast<std::size_t>(different); equal > 0)
    remarks.warn(counted(equal, "of the 'points' has the same position as another, so it makes",
                         "of the 'points' have the same positions as others, so they make") +
                 " no pieces. Give each point once.");
  const double far = kFarFromSolid * solid.box.longest_side();
  const Vec3d* outlier = nullptr;
  std::size_t outliers = 0;
  for (const Vec3d& p : points) {
    if (square_distance(solid.box, p) <= far * far) continue;
    if (!outlier) outlier = &p;
    ++outliers;
  }
  const std::vector<bool> inside = sites_detail::ColumnSampler(solid, 0, execution).inside(points);
  const bool none_inside = std::find(inside.begin(), inside.end(), true) == inside.end();
  if (!outlier && !none_inside) return;
  const Vec3d& sample = outlier ? *outlier : points[0];
  const std::optional<std::string> unit = outlier ? likely_unit(sample, solid) : std::nullopt;
  remarks.warn((none_inside ? "None of the 'points' is inside the mesh, so it may stay in one piece."
                            : counted(outliers, "of the 'points' is", "of the 'points' are") +
                                  " far outside the mesh and may make no pieces.") +
               (unit ? " 'points' are in metres, with y up, but " + written(sample, root_of(solid)) +
                           " looks like " + *unit + ": convert them to metres."
                     : " Move them into the mesh; coordinates are in metres, with y up."));
}

std::optional<FarPlace> far_place(const Solid& solid, const Vec3d& place, double near, const char* parameter,
                                  const Execution& execution) {
  if (solid.triangles.empty() ||
      sites_detail::ColumnSampler(solid, 0, execution).inside(std::span(&place, 1))[0])
    return std::nullopt;
  Pacer pacer(execution);
  const double distance = length(nearest_place(solid, place, pacer) - place);
  if (!(distance > near)) return std::nullopt;
  return FarPlace{written(place, root_of(solid)), distance, correction_of(place, parameter, solid)};
}

std::optional<std::string> likely_unit(const Vec3d& place, const Box& box) {
  // A place in another unit is in the box, and not just near the origin because it was scaled down.
  const double near = kFarFromSolid * box.longest_side();
  const std::pair<double, const char*> units[] = {
      {0.01, "centimetres"}, {0.001, "millimetres"}, {0.0254, "inches"}};
  for (const auto& [metres, name] : units)
    if (square_distance(box, metres * place) <= near * near && length(metres * place) >= near) return name;
  return std::nullopt;
}

}  // namespace fracture
