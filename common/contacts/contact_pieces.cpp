#include "common/contacts/contact_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "common/contacts/vertex_windings.hpp"

namespace fracture::contacts_detail {
namespace {

/// Triangles whose normals have a larger cosine may coincide. Normals of slivers are unreliable, but slivers add almost
/// no area.
constexpr double kAlike = 0.99;
/// A surface that coincides with another one is moved by this many roundings, so that all of it is on one
/// side.
constexpr double kMove = 2;
/// Shares of a triangle's area. Smaller areas than the first are noise. The second is the largest
/// difference between two sums that count as equal.
constexpr double kNothing = 1e-12, kSame = 1e-3;

Vec3f to_float(const Vec3d& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

template <class Item>
void sort_by_triangle(std::vector<Item>& items) {
  std::stable_sort(items.begin(), items.end(),
                   [](const Item& x, const Item& y) { return x.triangle < y.triangle; });
}

/// Returns the items of triangle k, which begin at `first`, and moves `first` past them.
template <class Item>
std::span<const Item> of_triangle(const std::vector<Item>& items, std::size_t& first, std::size_t k) {
  const std::size_t begin = first;
  while (first < items.size() && items[first].triangle == k) ++first;
  return {items.data() + begin, first - begin};
}

}  // namespace

/// Adds a convex polygon as a fan of pieces.
void PieceMaker::add_polygon(std::span<const Vec3d> corners, double area, const Vec3d& normal, double height,
                             std::vector<ContactPiece>& pieces) const {
  const auto twice = [&](std::size_t k) {
    const Vec3d across = cross(corners[k] - corners[0], corners[k + 1] - corners[0]);
    return length(across);
  };
  double whole = 0;
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) whole += twice(k);
  if (!(whole > 0)) return;
  for (std::size_t k = 1; k + 1 < corners.size(); k += 2) {
    const std::size_t last = std::min(k + 2, corners.size() - 1);
    const double share = (twice(k) + (last > k + 1 ? twice(k + 1) : 0)) / whole;
    if (!(share > 0)) continue;
    ContactPiece piece;
    const std::size_t used[4] = {0, k, k + 1, last};
    for (std::size_t c = 0; c < 4; ++c) piece.corners[c] = origin_ + corners[used[c]];
    piece.normal = to_float(normal);
    piece.height = static_cast<float>(height);
    piece.area = share * area;
    pieces.push_back(piece);
  }
}

void PieceMaker::add_facing(const Contact& contact, const NearPair& pair, const FacingPolygons& polygons,
                            std::vector<ContactPiece>& pieces) {
  origin_ = pair.origin;
  const std::vector<NearTriangle>& own = contact.of_b ? pair.b : pair.a;
  for (const FacingPolygon& p : polygons.polygons) {
    pacer_.step();
    const NearTriangle& t = own[p.triangle];
    add_polygon({polygons.corners.data() + p.first, p.size}, facing_share(t) * p.area, t.normal, p.height,
                pieces);
  }
}

void PieceMaker::add_common(const NearPair& pair, const Overlap& overlap, std::vector<ContactPiece>& pieces) {
  origin_ = pair.origin;
  Polygon polygon;
  for (const auto& [i, k] : overlap.flush_pairs) {
    pacer_.step(2);
    const double area = part_over(pair.a[i], pair.b[k], {-pair.rounding, pair.rounding}, true, polygon).area;
    if (area > 0)
      add_polygon({polygon.corners.data(), static_cast<std::size_t>(polygon.size)}, area, {}, 0, pieces);
  }
}

std::vector<char> PieceMaker::move_off(NearPair& pair, bool of_b, std::vector<Corners>& exact) {
  std::vector<NearTriangle>& own = of_b ? pair.b : pair.a;
  const std::vector<NearTriangle>& others = of_b ? pair.a : pair.b;
  // m², per triangle: its overlap with surface facing the same way, minus its overlap with surface facing it
  std::vector<double> on;
  std::vector<char> moved;
  for (const auto& p : pair.pairs) {
    pacer_.step();
    const std::uint32_t k = p[of_b ? 1 : 0];
    const NearTriangle &s = own[k], &t = others[p[of_b ? 0 : 1]];
    const double cosine = dot(s.normal, t.normal);
    if (!(std::fabs(cosine) > kAlike)) continue;
    const double common = part_over(s, t, {-pair.rounding, pair.rounding}, cosine > 0).area;
    if (!(common > 0)) continue;
    on.resize(own.size(), 0);
    on[k] += cosine > 0 ? common : -common;
  }
  if (on.empty()) return moved;
  moved.resize(own.size(), 0);
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (on[k] == 0) continue;
    moved[k] = 1;
    const Vec3d by = (on[k] > 0 ? kMove : -kMove) * pair.rounding * own[k].normal;
    for (std::size_t c = 0; c < 3; ++c) {
      exact[k][c] = to_double(to_float(exact[k][c] + by));
      own[k].corners[c] = exact[k][c] - pair.origin;
    }
  }
  return moved;
}

/// Returns the winding numbers at the corners of a triangle that shares no corners with others.
std::array<int, 3> PieceMaker::windings_alone(const Corners& corners, const Crossed& crossed,
                                              std::uint32_t around, Owner owner) {
  const int first = winding_around(surfaces_, around, corners[0], owner, pacer_);
  const int second = first + crossed.jumps[0];
  return {first, second, second + crossed.jumps[1]};
}

void PieceMaker::add_inside(const Contact& contact, NearPair& pair, const Overlap& overlap,
                            std::vector<ContactPiece>& pieces) {
  origin_ = pair.origin;
  const bool of_b = contact.of_b;
  const Owner owner = of_b ? Owner::kB : Owner::kA;
  const std::uint32_t around = of_b ? pair.part_a : pair.part_b;
  const std::vector<NearTriangle>& own = of_b ? pair.b : pair.a;
  const auto& windings = of_b ? overlap.windings_b : overlap.windings_a;
  std::vector<Corners> a = overlap.crossings.corners(Owner::kA), b = overlap.crossings.corners(Owner::kB);
  const std::vector<char> moved = move_off(pair, of_b, of_b ? b : a);
  std::optional<Crossings> anew;
  if (!moved.empty()) anew.emplace(surfaces_.solid(), pair, std::move(a), std::move(b), pacer_);
  const Crossings& crossings = anew ? *anew : overlap.crossings;
  std::vector<Segment> segments = crossings.segments(owner);
  std::vector<EdgeJump> jumps = crossings.jumps(owner);
  sort_by_triangle(segments);
  sort_by_triangle(jumps);

  std::size_t first_segment = 0, first_jump = 0;
  for (std::size_t k = 0; k < own.size(); ++k) {
    pacer_.step();
    const NearTriangle& t = own[k];
    const auto its_segments = of_triangle(segments, first_segment, k);
    const auto its_jumps = of_triangle(jumps, first_jump, k);
    const Crossed& crossed = crossings.of(owner)[k];
    const std::array<int, 3> at = !moved.empty() && moved[k]
                                      ? windings_alone(crossings.corners(owner)[k], crossed, around, owner)
                                      : windings[k];
    const double area = inside_of(t, crossed, at).area;
    if (!(std::fabs(area) > kNothing * t.area)) continue;
    const auto add_whole = [&] { add_polygon(t.corners, area, t.normal, 0, pieces); };
    if (!crossed.crossed) {
      add_whole();
      continue;
    }
    const std::vector<ConvexRegion>& all = sweep_.of(t, its_segments, its_jumps, at);
    double sum = 0;
    for (const ConvexRegion& made : all) sum += made.winding * made.area;
    if (!(std::fabs(sum - area) < kSame * t.area) || sum == 0) {  // rounding has inverted a region
      add_whole();
      continue;
    }
    for (const ConvexRegion& made : all)
      if (made.area > kNothing * t.area)
        add_polygon({made.corners.data(), made.size}, area / sum * made.winding * made.area, t.normal, 0,
                    pieces);
  }
}

}  // namespace fracture::contacts_detail
