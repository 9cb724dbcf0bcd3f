#include "common/contacts/facing.hpp"

namespace fracture::contacts_detail {
namespace {

/// Maximum cosine between normals of triangles that face each other.
constexpr double kFacing = -1.0 / 64;
/// Normals with this cosine are opposite apart from rounding, so one polygon serves both triangles.
constexpr double kOpposite = -1 + 1e-14;

/// Keeps the part of a polygon with height() >= 0.
template <class Height>
void cut(Polygon& polygon, const Height& height) {
  std::array<double, Polygon::kMost> heights;
  bool any_below = false;
  for (int k = 0; k < polygon.size; ++k) {
    const double h = height(polygon[k]);
    heights[static_cast<std::size_t>(k)] = h;
    any_below |= h < 0;
  }
  if (!any_below) return;
  Polygon kept;
  for (int k = 0; k < polygon.size; ++k) {
    const int next = k + 1 < polygon.size ? k + 1 : 0;
    const double here = heights[static_cast<std::size_t>(k)], there = heights[static_cast<std::size_t>(next)];
    if (here >= 0) kept.push(polygon[k]);
    // Computed from the kept side, so that both directions give the same point.
    if (here >= 0 && there < 0)
      kept.push(polygon[k] + (here / (here - there)) * (polygon[next] - polygon[k]));
    else if (here < 0 && there >= 0)
      kept.push(polygon[next] + (there / (there - here)) * (polygon[k] - polygon[next]));
  }
  polygon = kept;
}

}  // namespace

Patch part_over(const NearTriangle& s, const NearTriangle& t, const Range& range, bool turned_away,
                Polygon& polygon) {
  const Vec3d &n = s.normal, &foot = s.corners[0];
  polygon.size = 0;
  polygon.push(t.corners[0]);
  polygon.push(t.corners[turned_away ? 1 : 2]);  // in the orientation of s
  polygon.push(t.corners[turned_away ? 2 : 1]);
  cut(polygon, [&](const Vec3d& x) { return dot(n, x - foot) - range.low; });
  cut(polygon, [&](const Vec3d& x) { return range.high - dot(n, x - foot); });
  for (std::size_t k = 0; k < 3 && polygon.size > 0; ++k) {
    const Vec3d inwards = cross(n, s.corners[(k + 1) % 3] - s.corners[k]);
    cut(polygon, [&](const Vec3d& x) { return dot(inwards, x - s.corners[k]); });
  }
  Patch patch;
  for (int k = 2; k < polygon.size; ++k) {
    const Vec3d &p = polygon[0], &q = polygon[k - 1], &r = polygon[k];
    const double area = 0.5 * dot(n, cross(q - p, r - p));
    const Vec3d middle = (1.0 / 3) * (p + q + r);
    patch.add(area, area * (middle - dot(n, middle - foot) * n));
  }
  return patch.area > 0 ? patch : Patch{};
}

namespace {

/// Stores a polygon with its mean height over the plane through `foot`. Projects it onto this plane unless
/// `is_on_plane`.
void keep(const Polygon& polygon, std::uint32_t triangle, double area, const Vec3d& normal, const Vec3d& foot,
          bool is_on_plane, FacingPolygons& kept) {
  FacingPolygon made{triangle, static_cast<std::uint32_t>(kept.corners.size()),
                     static_cast<std::uint32_t>(polygon.size), area, 0};
  for (int c = 0; c < polygon.size; ++c) {
    const double height = dot(normal, polygon[c] - foot);
    made.height += height / polygon.size;
    kept.corners.push_back(is_on_plane ? polygon[c] : polygon[c] - height * normal);
  }
  kept.polygons.push_back(made);
}

}  // namespace

void add_facing(NearTriangle& s, std::uint32_t i, FacingPolygons& of_s, NearTriangle& t, std::uint32_t k,
                FacingPolygons& of_t, const Range& range) {
  const double cosine = dot(s.normal, t.normal);
  if (!(cosine < kFacing)) return;
  Polygon polygon;
  const Patch over_t = part_over(s, t, range, false, polygon);
  s.faced.add(over_t.area, over_t.moment);
  if (over_t.area > 0) keep(polygon, i, over_t.area, s.normal, s.corners[0], false, of_s);
  if (cosine > kOpposite) {
    const Patch over_s = part_over(t, s, range, false, polygon);
    t.faced.add(over_s.area, over_s.moment);
    if (over_s.area > 0) keep(polygon, k, over_s.area, t.normal, t.corners[0], false, of_t);
  } else {
    const double apart = dot(s.normal, t.corners[0] - s.corners[0]);
    t.faced.add(over_t.area, over_t.moment + (over_t.area * apart) * s.normal);
    if (over_t.area > 0) {
      keep(polygon, k, over_t.area, s.normal, s.corners[0], true, of_t);
    }
  }
}

Faced faced_by(const std::vector<NearTriangle>& triangles) {
  Faced faced;
  for (const NearTriangle& t : triangles) {
    if (!(t.faced.area > 0)) continue;
    const double share = facing_share(t);
    const double area = share * t.faced.area;
    faced.patch.add(area, share * t.faced.moment);
    faced.outward = faced.outward + area * t.normal;
  }
  return faced;
}

}  // namespace fracture::contacts_detail
