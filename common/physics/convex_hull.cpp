#include "common/physics/convex_hull.hpp"

#include <algorithm>
#include <cmath>

#include "common/mesh/mesh.hpp"

namespace fracture {
namespace {

/// 2^19 - 1: components of normals stay below 2^39, their products with points below 3 * 2^58.
constexpr double kLastStep = 524287;
/// Steps of the grid: what is no thicker may be flat but for rounding.
constexpr double kFlat = 4;

}  // namespace

void ConvexHullBuilder::round_to_grid(std::span<const Vec3f> points, Pacer& pacer) {
  Box box;
  for (const Vec3f& p : points) box.add(to_double(p));
  // Each axis has a scale of its own: affine maps keep hulls.
  Vec3d scale;
  for (int a = 0; a < 3; ++a) scale[a] = box.max[a] > box.min[a] ? kLastStep / (box.max[a] - box.min[a]) : 0;
  grid_.clear();
  for (const Vec3f& p : points) {
    pacer.step();
    const Vec3d q = to_double(p) - box.min;
    grid_.push_back({static_cast<std::int64_t>(q.x * scale.x + 0.5),
                     static_cast<std::int64_t>(q.y * scale.y + 0.5),
                     static_cast<std::int64_t>(q.z * scale.z + 0.5)});
  }
}

bool ConvexHullBuilder::lexicographic_less(std::uint32_t a, std::uint32_t b) const {
  const GridPoint &p = grid_[a], &q = grid_[b];
  if (p.x != q.x) return p.x < q.x;
  if (p.y != q.y) return p.y < q.y;
  return p.z < q.z;
}

std::uint32_t ConvexHullBuilder::add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const GridPoint &p = grid_[a], &q = grid_[b], &r = grid_[c];
  const GridPoint u{q.x - p.x, q.y - p.y, q.z - p.z}, v{r.x - p.x, r.y - p.y, r.z - p.z};
  const GridPoint n{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
  faces_.push_back({{a, b, c},
                    {kNoIndex, kNoIndex, kNoIndex},
                    n,
                    n.x * p.x + n.y * p.y + n.z * p.z,
                    kNoIndex,
                    0,
                    false,
                    true});
  return static_cast<std::uint32_t>(faces_.size() - 1);
}

/// Puts p on the list of the first of the faces that it lies above; points above none are inside.
void ConvexHullBuilder::put_outside(std::uint32_t p, std::uint32_t first_face, std::uint32_t end_face,
                                    Pacer& pacer) {
  std::uint32_t f = first_face;
  while (f < end_face && above(faces_[f], p) <= 0) ++f;
  pacer.step(1 + f - first_face);
  if (f == end_face) return;
  next_[p] = faces_[f].first_outside;
  faces_[f].first_outside = p;
}

/// Four extreme points that span a volume; false when there are none.
bool ConvexHullBuilder::first_tetrahedron(Pacer& pacer) {
  const auto count = static_cast<std::uint32_t>(grid_.size());
  std::uint32_t a = 0, b = 0;
  for (std::uint32_t p = 1; p < count; ++p) {
    pacer.step();
    if (lexicographic_less(p, a)) a = p;
    if (lexicographic_less(b, p)) b = p;
  }
  if (!lexicographic_less(a, b)) return false;
  // Farthest from the line; which one is chosen may depend on rounding only among equals, and is the same
  // everywhere.
  std::uint32_t c = kNoIndex;
  double farthest = 0;
  const auto to_a = [&](std::uint32_t p) {
    return Vec3d{static_cast<double>(grid_[p].x - grid_[a].x), static_cast<double>(grid_[p].y - grid_[a].y),
                 static_cast<double>(grid_[p].z - grid_[a].z)};
  };
  const Vec3d ab = to_a(b);
  for (std::uint32_t p = 0; p < count; ++p) {
    pacer.step();
    const Vec3d n = cross(ab, to_a(p));  // components are exact: below 2^39
    const double d = dot(n, n);
    if (d > farthest || (d > 0 && d == farthest && lexicographic_less(c, p))) {
      farthest = d;
      c = p;
    }
  }
  if (c == kNoIndex) return false;
  faces_.clear();
  const Face base = faces_[add_face(a, b, c)];
  std::uint32_t d = kNoIndex;
  std::int64_t highest = 0;
  for (std::uint32_t p = 0; p < count; ++p) {
    pacer.step();
    const std::int64_t h = std::abs(above(base, p));
    if (h > highest || (h > 0 && h == highest && lexicographic_less(d, p))) {
      highest = h;
      d = p;
    }
  }
  const Vec3d n{static_cast<double>(base.normal.x), static_cast<double>(base.normal.y),
                static_cast<double>(base.normal.z)};
  if (d == kNoIndex || static_cast<double>(highest) <= kFlat * length(n)) return false;
  if (above(base, d) > 0) std::swap(b, c);  // so that d is below (a, b, c)
  faces_.clear();
  add_face(a, b, c);
  add_face(a, d, b);
  add_face(b, d, c);
  add_face(c, d, a);
  faces_[0].neighbour = {1, 2, 3};
  faces_[1].neighbour = {3, 2, 0};
  faces_[2].neighbour = {1, 3, 0};
  faces_[3].neighbour = {2, 1, 0};
  for (std::uint32_t p = 0; p < count; ++p) put_outside(p, 0, 4, pacer);
  return true;
}

//       \ unseen /
//    a --horizon--> b       The faces that see p are taken away. The horizon is one cycle; each of its
//       \  new   /          edges becomes a triangle (a, b, p). None is degenerate: p on the line a b
//        \ face /           would lie in the plane of the seen face at that edge, and then that face
//           p               would not see p.
void ConvexHullBuilder::insert_farthest(std::uint32_t face, Pacer& pacer) {
  std::uint32_t p = kNoIndex;
  std::int64_t highest = 0;
  // Ties go to the lexicographically last: an extreme point even within a facet of coplanar points.
  for (std::uint32_t q = faces_[face].first_outside; q != kNoIndex; q = next_[q]) {
    pacer.step();
    const std::int64_t h = above(faces_[face], q);
    if (h > highest || (h == highest && lexicographic_less(p, q))) {
      highest = h;
      p = q;
    }
  }

  ++stamp_;
  visible_.assign(1, face);
  horizon_.clear();  // pairs: the seen face, which edge of it
  faces_[face].stamp = stamp_;
  faces_[face].visible = true;
  for (std::size_t k = 0; k < visible_.size(); ++k)
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t g = faces_[visible_[k]].neighbour[e];
      if (faces_[g].stamp != stamp_) {
        faces_[g].stamp = stamp_;
        faces_[g].visible = above(faces_[g], p) > 0;
        if (faces_[g].visible) visible_.push_back(g);
      }
      if (!faces_[g].visible) {
        horizon_.push_back(visible_[k]);
        horizon_.push_back(e);
      }
    }

  const auto first = static_cast<std::uint32_t>(faces_.size());
  for (std::size_t k = 0; k < horizon_.size(); k += 2) {
    const Face seen = faces_[horizon_[k]];
    const std::uint32_t e = horizon_[k + 1], a = seen.v[e], b = seen.v[(e + 1) % 3];
    const std::uint32_t unseen = seen.neighbour[e], made = add_face(a, b, p);
    faces_[made].neighbour[0] = unseen;
    for (std::uint32_t j = 0; j < 3; ++j)
      if (faces_[unseen].v[j] == b && faces_[unseen].v[(j + 1) % 3] == a) faces_[unseen].neighbour[j] = made;
    new_face_from_[a] = made;
  }
  const auto end = static_cast<std::uint32_t>(faces_.size());
  for (std::uint32_t f = first; f < end; ++f) {
    const std::uint32_t following = new_face_from_[faces_[f].v[1]];
    faces_[f].neighbour[1] = following;
    faces_[following].neighbour[2] = f;
  }
  for (const std::uint32_t f : visible_) {
    faces_[f].alive = false;
    for (std::uint32_t q = faces_[f].first_outside; q != kNoIndex;) {
      const std::uint32_t after = next_[q];
      if (q != p) put_outside(q, first, end, pacer);
      q = after;
    }
    faces_[f].first_outside = kNoIndex;
  }
  for (std::uint32_t f = first; f < end; ++f)
    if (faces_[f].first_outside != kNoIndex) pending_.push_back(f);
}

const ConvexHullBuilder::Triangles& ConvexHullBuilder::build(std::span<const Vec3f> points,
                                                             std::uint32_t max_points,
                                                             const Execution& execution) {
  Pacer pacer(execution);
  triangles_.clear();
  stopped_early_ = false;
  if (points.size() < 4) return triangles_;
  round_to_grid(points, pacer);
  next_.resize(points.size());
  new_face_from_.resize(points.size());
  stamp_ = 0;
  if (!first_tetrahedron(pacer)) return triangles_;
  // First come, first served: the hull grows on all sides alike, so that stopping early leaves no side out.
  std::uint32_t inserted = 4;
  pending_ = {0, 1, 2, 3};
  for (std::size_t k = 0; k < pending_.size(); ++k) {
    const Face& f = faces_[pending_[k]];
    if (!f.alive || f.first_outside == kNoIndex) continue;
    stopped_early_ = inserted == max_points;
    if (stopped_early_) break;
    insert_farthest(pending_[k], pacer);
    ++inserted;
  }
  for (const Face& f : faces_)
    if (f.alive) triangles_.push_back(f.v);
  return triangles_;
}

}  // namespace fracture
