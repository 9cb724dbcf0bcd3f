#include "common/physics/surface_hull.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/mesh/mesh.hpp"

namespace fracture {
namespace {

/// Steps: what is surely thicker than what HullGrid::first_tetrahedron() calls flat.
constexpr double kThick = 8;
/// Half-edges of a point that wait for their twins.
constexpr std::size_t kLongestChain = 256;
/// One in so many corners may be needless: where a cut crosses the diagonal of a flat face, it has one.
constexpr std::size_t kFewBlunt = 4;

double largest(const Vec3d& v) { return std::max(std::fabs(v.x), std::max(std::fabs(v.y), std::fabs(v.z))); }

}  // namespace

/// False where the edge (a, b) bends inwards: where the diagonals of its two triangles pass each other at a
/// distance. Unlike the height of a corner above the plane of a sliver that is no larger than what rounding did
/// to the corners.
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

/// Four points at a time: the grid's, as floats, which is exact.
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

/// Whether a point is above the face by more than `most`. Floats find what is clear: with the normal's largest component
/// made 1, products below 2^19 and sums below 3 * 2^19 round by less than half a step together, and so does the limit.
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

/// Bends that are small at each edge may add up, or be those of narrow strips between large faces.
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

/// A row of strips may bend inwards a little at each edge, and much from end to end: while all of it is smaller than the
/// largest triangles. What rounding turns the plane of a triangle by is allowed for.
bool SurfaceHull::nothing_above_the_bent(const HullGrid& grid, Pacer& pacer) const {
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    if (!face.bent) continue;
    double longest = 0;
    for (std::size_t h = 4 * f; h < 4 * f + 3; ++h)
      longest = std::max(longest, largest(grid[corners_[h + 1]] - grid[corners_[h]]));
    const double turned =
        HullGrid::kSide * longest / largest(face.plane.normal);  // by a step, at the far end
    if (anything_above(grid, face, (kMostAbove + turned) * face.rounding, pacer)) return false;
  }
  return true;
}

/// False, too, where a triangle is degenerate or inside out, an edge is not that of two triangles, once in each direction
/// (but for those between what is uncut and cuts), or the body is flat: the width of a convex body is at least 2 V / A.
/// Most bodies that are not convex are known after a few triangles.
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
      std::size_t chain = 0;  // at a hub, and with triangles in any order, it may be long
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

/// The cell bends outwards at its own edges, and so does the body where a cut ends at its surface: what sticks out
/// there is not asked by how much.
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
  // A surface without holes whose edges bend outwards is that of one convex body, and not wound around it twice,
  // if only one point is higher than all its neighbours.
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
