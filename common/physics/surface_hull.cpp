#include "common/physics/surface_hull.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/mesh/mesh.hpp"

namespace fracture {
namespace {

/// Steps of the grid: a body this thick is never flat for HullGrid::first_tetrahedron().
constexpr double kThick = 8;
/// Maximum number of a point's half-edges without a twin.
constexpr std::size_t kLongestChain = 256;
/// At most one in this many corners may be unnecessary. A cut makes such a corner on the diagonal of a flat face.
constexpr std::size_t kFewBlunt = 4;

double largest(const Vec3d& v) { return std::max(std::fabs(v.x), std::max(std::fabs(v.y), std::fabs(v.z))); }

}  // namespace

/// Returns false if the edge (a, b) bends inwards by more than rounding. The bend is measured by the distance between the
/// diagonals of its two triangles. Rounding changes this distance no more than it moves the corners. It may change the
/// height of a corner above the plane of a sliver much more.
bool SurfaceHull::add_edge(const HullGrid& grid, std::uint32_t a, std::uint32_t b, Face& left, Face& right) {
  Point &from = points_[a], &to = points_[b];
  const bool rises = grid.less(a, b);
  from.climbs |= rises;
  to.climbs |= !rises;
  const std::uint32_t apex = right.corners_sum - a - b;
  const double six_volumes = grid.height(left.plane, apex);
  const std::uint32_t crease = six_volumes < -left.rounding;
  const std::uint32_t outwards =
      six_volumes < -HullGrid::kHeightError ||
      (six_volumes <= HullGrid::kHeightError && grid.exact_height(left.plane.normal, a, apex) < 0);
  from.creases += crease;
  to.creases += crease;
  from.edges += outwards;
  to.edges += outwards;
  if (outwards || six_volumes <= 0) return true;
  left.bent = right.bent = true;
  const std::uint32_t other = left.corners_sum - a - b;
  return six_volumes <= kRounding * largest(cross(grid[b] - grid[a], grid[apex] - grid[other]));
}

/// Lists the grid's points in groups of four, as floats, which is exact.
void SurfaceHull::list_quads(const HullGrid& grid, Pacer& pacer) {
  quads_.clear();
  quads_.reserve((grid.size() + 3) / 4);
  for (std::uint32_t p = 0; p < grid.size(); p += 4) {
    Quad& quad = quads_.emplace_back();
    for (std::uint32_t k = 0; k < 4; ++k) {
      const Vec3d& at = grid[std::min(p + k, grid.size() - 1)];
      quad.x[k] = static_cast<float>(at.x);
      quad.y[k] = static_cast<float>(at.y);
      quad.z[k] = static_cast<float>(at.z);
    }
  }
  pacer.step(grid.size());
}

/// Whether a point is above the face by more than `most`. Floats decide clear cases. With the normal's largest component
/// scaled to 1, products are below 2^19 and sums below 3 * 2^19: they round by less than half a step, and so does the limit.
bool SurfaceHull::anything_above(const HullGrid& grid, const Face& face, double most, Pacer& pacer) const {
  const HullGrid::Plane& plane = face.plane;
  const double size = largest(plane.normal);
  const Vec3d normal = (1 / size) * plane.normal;
  const auto x = static_cast<float>(normal.x), y = static_cast<float>(normal.y),
             z = static_cast<float>(normal.z);
  Quad::Four highest = x * quads_[0].x + y * quads_[0].y + z * quads_[0].z;
  for (const Quad& q : quads_) {
    const Quad::Four height = x * q.x + y * q.y + z * q.z;
    highest = height > highest ? height : highest;
  }
  pacer.step(quads_.size());
  const auto clear = static_cast<float>((plane.offset + most - HullGrid::kHeightError) / size - 1);
  if (highest[0] < clear && highest[1] < clear && highest[2] < clear && highest[3] < clear) return false;
  for (std::uint32_t p = 0; p < grid.size(); ++p)
    if (grid.height(plane, p) > most) return true;
  pacer.step(grid.size());
  return false;
}

/// Needed because small bends at edges may add up, or belong to narrow strips between large faces.
bool SurfaceHull::nothing_above_the_largest(const HullGrid& grid, Pacer& pacer) {
  largest_.resize(faces_.size());
  std::iota(largest_.begin(), largest_.end(), 0u);
  const std::size_t count = std::min(kLargest, largest_.size());
  if (count == 0) return true;
  std::nth_element(largest_.begin(), largest_.begin() + static_cast<std::ptrdiff_t>(count) - 1,
                   largest_.end(), [&](std::uint32_t f, std::uint32_t g) {
                     const double a = faces_[f].rounding, b = faces_[g].rounding;
                     return a != b ? a > b : f < g;
                   });
  for (std::size_t k = 0; k < count; ++k) {
    Face& face = faces_[largest_[k]];
    if (anything_above(grid, face, kMostAbove * face.rounding, pacer)) return false;
    face.bent = false;  // nothing_above_the_bent() would allow more
  }
  return true;
}

/// Needed because a row of strips may bend inwards a little at each edge, but much from end to end, and be smaller than the
/// largest triangles. The limit allows for rounding, which may tilt the plane of a triangle.
bool SurfaceHull::nothing_above_the_bent(const HullGrid& grid, Pacer& pacer) const {
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    if (!face.bent) continue;
    double longest = 0;
    for (std::size_t h = 4 * f; h < 4 * f + 3; ++h)
      longest = std::max(longest, largest(grid[corners_[h + 1]] - grid[corners_[h]]));
    const double turned =
        HullGrid::kSide * longest / largest(face.plane.normal);  // tilt by one step, at the far end
    if (anything_above(grid, face, (kMostAbove + turned) * face.rounding, pacer)) return false;
  }
  return true;
}

/// Also returns false if a triangle is degenerate or inside out, or the body is flat (the width of a convex body is at least
/// 2 V / A), or an edge does not have two triangles, one in each direction. Edges between uncut triangles and cuts are
/// exempt. Most bodies that are not convex are recognized after a few triangles.
bool SurfaceHull::bends_outwards(const HullGrid& grid, const BodySurface& surface, Pacer& pacer) {
  faces_.clear();
  corners_.clear();
  after_.clear();
  const std::size_t count = surface.uncut().value_or(surface.size());
  faces_.reserve(count);
  corners_.reserve(4 * count);
  after_.reserve(4 * count);
  points_.assign(grid.size(), {kNoIndex, 0, 0, false});
  double six_volumes = 0, sizes = 0;
  std::size_t pairs = 0;
  Vec3d middle;
  pacer.each(0, grid.size(), [&](std::size_t p) { middle = middle + grid[static_cast<std::uint32_t>(p)]; });
  middle = (1.0 / grid.size()) * middle;
  for (std::size_t f = 0; f < count; ++f) {
    const auto [a0, b0, c0] = surface[f];
    const HullGrid::Plane plane = grid.plane(a0, b0, c0);
    const double size = largest(plane.normal);
    if (size == 0 || dot(plane.normal, middle) >= plane.offset) return false;
    faces_.push_back({plane, kRounding * size, a0 + b0 + c0, false});
    corners_.insert(corners_.end(), {a0, b0, c0, a0});
    after_.insert(after_.end(), 4, kNoIndex);
    six_volumes += plane.offset;
    sizes += size;
    for (auto h = static_cast<HalfEdge>(4 * f); h < 4 * f + 3; ++h) {
      const std::uint32_t a = corners_[h], b = corners_[h + 1];
      HalfEdge* link = &points_[b].open;
      std::size_t chain = 0;  // may be long at a hub with triangles in arbitrary order
      for (; *link != kNoIndex && corners_[*link + 1] != a; link = &after_[*link])
        if (++chain > kLongestChain) return false;
      pacer.step(1 + chain);
      if (*link == kNoIndex) {
        after_[h] = points_[a].open;
        points_[a].open = h;
        continue;
      }
      if (!add_edge(grid, a, b, faces_[f], faces_[*link / 4])) return false;
      *link = after_[*link];
      ++pairs;
    }
  }
  if (surface.uncut()) {
    look_at_cuts(grid, surface, pacer);
    return true;
  }
  return 2 * pairs == 3 * faces_.size() &&
         six_volumes > 3 * kThick * sizes;  // twice an area is at most sqrt(3) times its size
}

/// The cell bends outwards at its own edges, and so does the body where a cut ends at its surface. So all corners of cuts
/// count as sticking out, without being measured.
void SurfaceHull::look_at_cuts(const HullGrid& grid, const BodySurface& surface, Pacer& pacer) {
  const auto climb = [&](std::uint32_t a, std::uint32_t b) {
    const bool rises = grid.less(a, b);
    points_[a].climbs |= rises;
    points_[b].climbs |= !rises;
  };
  pacer.each(*surface.uncut(), surface.size(), [&](std::size_t f) {
    const auto [a, b, c] = surface[f];
    climb(a, b);
    climb(b, c);
    climb(c, a);
    for (const std::uint32_t p : {a, b, c}) points_[p].edges = points_[p].creases = 3;
  });
}

SurfaceHull::Shape SurfaceHull::shape_of(const HullGrid& grid, const BodySurface& surface,
                                         std::uint32_t max_points, Pacer& pacer) {
  if (surface.size() + 4 != 2 * std::size_t{grid.size()}) return Shape::kOther;  // Euler: no sphere
  if (!bends_outwards(grid, surface, pacer)) return Shape::kOther;
  // A surface without holes whose edges bend outwards encloses a convex body. It winds around the body only once if only
  // one point is higher than all its neighbours.
  std::size_t blunt = 0, summits = 0;
  for (const Point& p : points_) {
    blunt += p.creases < 3;
    summits += !p.climbs;
  }
  if (summits != 1) return Shape::kOther;
  if (grid.size() > max_points || blunt > points_.size() / kFewBlunt) return Shape::kConvex;
  list_quads(grid, pacer);
  return nothing_above_the_largest(grid, pacer) && nothing_above_the_bent(grid, pacer) ? Shape::kHull
                                                                                       : Shape::kConvex;
}

void SurfaceHull::list_sharp(std::vector<std::uint32_t>& out) const {
  out.clear();
  for (std::uint32_t p = 0; p < points_.size(); ++p)
    if (points_[p].edges >= 3) out.push_back(p);
}

}  // namespace fracture
