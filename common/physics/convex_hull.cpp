#include "common/physics/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/mesh/mesh.hpp"

namespace fracture {

void ConvexHullBuilder::add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                 const std::array<std::uint32_t, 3>& neighbour) {
  faces_.push_back(
      {{a, b, c}, neighbour, grid_.plane(a, b, c), -HUGE_VAL, kNoIndex, kNoIndex, 0, false, true});
}

/// Puts p on the face's list where it lies above it, at the height of about h.
inline bool ConvexHullBuilder::put_outside(std::uint32_t p, Face& f, double h) {
  if (!is_above(f, p, h)) return false;
  next_[p] = f.first_outside;
  f.first_outside = p;
  const double higher = h - f.highest;
  if (higher < -2 * HullGrid::kHeightError) return true;
  if (higher <= 2 * HullGrid::kHeightError) {
    // Ties go to the lexicographically last: an extreme point even within a facet of coplanar points. Of points at
    // one place the first one stays.
    const std::int64_t height = grid_.exact_height(f.plane.normal, f.v[0], p),
                       highest = grid_.exact_height(f.plane.normal, f.v[0], f.farthest);
    if (height < highest || (height == highest && !grid_.less(f.farthest, p))) return true;
  }
  f.highest = h;
  f.farthest = p;
  return true;
}

/// Puts each point on the list of the first of the faces from there on that it lies above; points above none are
/// inside.
void ConvexHullBuilder::divide_homeless(std::uint32_t first_face, Pacer& pacer) {
  const std::size_t count = faces_.size() - first_face, pairs = (count + 1) / 2;
  Face* const faces = faces_.data() + first_face;
  planes_.resize(pairs);
  planes_.back().set(1, HullGrid::kAboveAll);
  for (std::size_t k = 0; k < count; ++k) planes_[k / 2].set(k % 2, faces[k].plane);
  const HullGrid::PlanePair* const planes = planes_.data();
  for (const std::uint32_t p : homeless_) {
    const Vec3d& at = grid_[p];
    std::size_t k = 0;
    for (; k < pairs; ++k) {
      const HullGrid::PlanePair::Pair h = planes[k].heights(at);
      if (h[0] >= -HullGrid::kHeightError && put_outside(p, faces[2 * k], h[0])) break;
      if (h[1] >= -HullGrid::kHeightError && put_outside(p, faces[2 * k + 1], h[1])) break;
    }
    pacer.step(1 + k);
  }
}

/// The faces that see p, and their boundary in order: around each face from the edge by which it was entered, and
/// into those beyond its edges before it goes on (Lloyd's implementation, quickhull3d, has it so).
void ConvexHullBuilder::find_horizon(std::uint32_t face, std::uint32_t p) {
  ++stamp_;
  visible_.clear();
  horizon_.clear();
  visible_.push_back(face);
  faces_[face].stamp = stamp_;
  faces_[face].visible = true;
  steps_.push_back({face, 0, 3});
  while (!steps_.empty()) {
    Step& step = steps_.back();
    if (step.left == 0) {
      steps_.pop_back();
      continue;
    }
    const Face& f = faces_[step.face];
    const std::uint32_t a = f.v[step.edge], g = f.neighbour[step.edge];
    step.edge = step.edge == 2 ? 0 : static_cast<std::uint8_t>(step.edge + 1);
    --step.left;
    const std::uint32_t b = f.v[step.edge];
    Face& other = faces_[g];
    if (other.stamp != stamp_) {
      other.stamp = stamp_;
      other.visible = is_above(other, p, grid_.height(other.plane, p));
      if (other.visible) {
        visible_.push_back(g);
        const int after = other.v[0] == a ? 0 : other.v[1] == a ? 1 : 2;  // its edge from b to a ends there
        steps_.push_back({g, static_cast<std::uint8_t>(after), 2});
        continue;
      }
    }
    if (!other.visible) horizon_.push_back({a, b, g});
  }
}

//       \ unseen /
//    a --horizon--> b       The faces that see p are taken away. The horizon is one cycle; each of its
//       \  new   /          edges becomes a triangle (a, b, p). None is degenerate: p on the line a b
//        \ face /           would lie in the plane of the seen face at that edge, and then that face
//           p               would not see p.
void ConvexHullBuilder::insert_farthest(std::uint32_t face, Pacer& pacer) {
  const std::uint32_t p = faces_[face].farthest;
  find_horizon(face, p);
  const auto first = static_cast<std::uint32_t>(faces_.size());
  const auto count = static_cast<std::uint32_t>(horizon_.size());
  pacer.step(visible_.size() + count);
  for (std::uint32_t k = 0; k < count; ++k) {
    const HorizonEdge& edge = horizon_[k];
    Face& unseen = faces_[edge.unseen];
    unseen.neighbour[unseen.v[0] == edge.b ? 0 : unseen.v[1] == edge.b ? 1 : 2] = first + k;
    add_face(edge.a, edge.b, p,
             {edge.unseen, first + (k + 1 == count ? 0 : k + 1), first + (k == 0 ? count : k) - 1});
  }
  homeless_.clear();
  for (const std::uint32_t f : visible_) {
    faces_[f].alive = false;
    for (std::uint32_t q = faces_[f].first_outside; q != kNoIndex; q = next_[q])
      if (q != p) homeless_.push_back(q);
    faces_[f].first_outside = kNoIndex;
  }
  divide_homeless(first, pacer);
  for (std::uint32_t f = first; f < first + count; ++f)
    if (faces_[f].first_outside != kNoIndex) pending_.push_back(f);
}

void ConvexHullBuilder::quickhull(const std::array<std::uint32_t, 4>& first, std::uint32_t max_points,
                                  Pacer& pacer) {
  const auto [a, b, c, d] = first;
  next_.resize(grid_.size());
  stamp_ = 0;
  faces_.clear();
  add_face(a, b, c, {1, 2, 3});
  add_face(a, d, b, {3, 2, 0});
  add_face(b, d, c, {1, 3, 0});
  add_face(c, d, a, {2, 1, 0});
  homeless_.resize(grid_.size());
  std::iota(homeless_.begin(), homeless_.end(), 0u);
  divide_homeless(0, pacer);
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
}

const ConvexHullBuilder::Triangles& ConvexHullBuilder::build(std::span<const Vec3f> points,
                                                             std::uint32_t max_points,
                                                             const Execution& execution,
                                                             const BodySurface& surface) {
  Pacer pacer(execution);
  triangles_.clear();
  stopped_early_ = false;
  if (points.size() < 4) return triangles_;
  grid_.round(points, pacer);
  const SurfaceHull::Shape shape = surface_.shape_of(grid_, surface, max_points, pacer);
  if (shape == SurfaceHull::Shape::kHull) {
    triangles_.reserve(surface.size());
    for (std::size_t t = 0; t < surface.size(); ++t) triangles_.push_back(surface[t]);
    return triangles_;
  }
  if (shape == SurfaceHull::Shape::kOther) {
    if (const auto first = grid_.first_tetrahedron(pacer)) quickhull(*first, max_points, pacer);
    return triangles_;
  }
  surface_.list_sharp(number_);
  pacer.step(number_.size());
  grid_.keep(number_);
  if (const auto first = grid_.first_tetrahedron(pacer)) quickhull(*first, max_points, pacer);
  for (auto& t : triangles_) t = {number_[t[0]], number_[t[1]], number_[t[2]]};
  return triangles_;
}

}  // namespace fracture
