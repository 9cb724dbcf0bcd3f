#include "common/physics/convex_hull.hpp"

#include <algorithm>
#include <cmath>

#include "common/mesh/mesh.hpp"

namespace fracture {

bool ConvexHullBuilder::lexicographic_less(std::uint32_t a, std::uint32_t b) const {
  const GridPoint &p = points_[a], &q = points_[b];
  if (p.x != q.x) return p.x < q.x;
  if (p.y != q.y) return p.y < q.y;
  return p.z < q.z;
}

std::int64_t ConvexHullBuilder::least_above(const GridPoint& normal) const {
  if (tolerance_ == 0) return 0;
  const auto real = [](std::int64_t x) { return static_cast<double>(x); };
  return static_cast<std::int64_t>(tolerance_ * length({real(normal.x), real(normal.y), real(normal.z)}));
}

std::uint32_t ConvexHullBuilder::add_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const GridPoint &p = points_[a], &q = points_[b], &r = points_[c];
  const GridPoint u{q.x - p.x, q.y - p.y, q.z - p.z}, v{r.x - p.x, r.y - p.y, r.z - p.z};
  const GridPoint n{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
  faces_.push_back({{a, b, c},
                    {kNoIndex, kNoIndex, kNoIndex},
                    n,
                    n.x * p.x + n.y * p.y + n.z * p.z,
                    least_above(n),
                    kNoIndex,
                    kNoIndex,
                    0,
                    0,
                    false,
                    true});
  return static_cast<std::uint32_t>(faces_.size() - 1);
}

/// Adds p to the list of the first face that it is above by more than the tolerance. Points above no face are inside, apart
/// from the tolerance.
void ConvexHullBuilder::put_outside(std::uint32_t p, std::uint32_t first_face, std::uint32_t end_face,
                                    Pacer& pacer) {
  for (std::uint32_t f = first_face; f < end_face; ++f) {
    Face& face = faces_[f];
    const std::int64_t h = above(face, p);
    if (h <= face.least) continue;
    next_[p] = face.first_outside;
    face.first_outside = p;
    // Ties go to the lexicographically last point, because it is extreme even among coplanar points.
    if (h > face.highest || (h == face.highest && lexicographic_less(face.farthest, p))) {
      face.highest = h;
      face.farthest = p;
    }
    return pacer.step(1 + f - first_face);
  }
  pacer.step(1 + end_face - first_face);
}

/// Finds the faces that see p, and their boundary in order. The search is depth-first, as in Lloyd's quickhull3d. It goes around
/// each face, starting at the edge through which it entered. At each edge, it first searches the neighbouring face.
void ConvexHullBuilder::find_horizon(std::uint32_t face, std::uint32_t p) {
  ++stamp_;
  visible_.assign(1, face);
  horizon_.clear();
  faces_[face].stamp = stamp_;
  faces_[face].visible = true;
  steps_.assign(1, {face, 0, 3});
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
      other.visible = above(other, p) > 0;
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
//    a --horizon--> b       The faces that see p are removed. The horizon is one cycle; each of its
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
    const std::uint32_t made = add_face(edge.a, edge.b, p);
    faces_[made].neighbour = {edge.unseen, first + (k + 1 == count ? 0 : k + 1),
                              first + (k == 0 ? count : k) - 1};
    Face& unseen = faces_[edge.unseen];
    unseen.neighbour[unseen.v[0] == edge.b ? 0 : unseen.v[1] == edge.b ? 1 : 2] = made;
  }
  const std::uint32_t end = first + count;
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

void ConvexHullBuilder::quickhull(const std::array<std::uint32_t, 4>& first, std::uint32_t max_points,
                                  double tolerance, Pacer& pacer) {
  const auto [a, b, c, d] = first;
  const auto whole = [](double x) { return static_cast<std::int64_t>(x); };
  points_.resize(grid_.size());
  pacer.each(0, points_.size(), [&](std::size_t k) {
    const Vec3d& p = grid_[static_cast<std::uint32_t>(k)];
    points_[k] = {whole(p.x), whole(p.y), whole(p.z)};
  });
  next_.resize(points_.size());
  stamp_ = 0;
  faces_.clear();
  // Relative to the height of the first tetrahedron, not to the body's length, so that thin bodies keep their edges.
  const Vec3d normal = grid_.plane(a, b, c).normal;
  tolerance_ = tolerance * std::fabs(static_cast<double>(grid_.exact_height(normal, a, d))) / length(normal);
  add_face(a, b, c);
  add_face(a, d, b);
  add_face(b, d, c);
  add_face(c, d, a);
  faces_[0].neighbour = {1, 2, 3};
  faces_[1].neighbour = {3, 2, 0};
  faces_[2].neighbour = {1, 3, 0};
  faces_[3].neighbour = {2, 1, 0};
  for (std::uint32_t p = 0; p < points_.size(); ++p) put_outside(p, 0, 4, pacer);
  // First in, first out: the hull grows evenly on all sides, so stopping early leaves out no side.
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
                                                             const BodySurface& surface, double tolerance) {
  Pacer pacer(execution);
  triangles_.clear();
  stopped_early_ = false;
  if (points.size() < 4) return triangles_;
  grid_.round(points, pacer);
  // A surface with too many points cannot be the hull. It is not tested if Quickhull may leave out points anyway.
  const bool asked = tolerance == 0 || grid_.size() <= max_points;
  const SurfaceHull::Shape shape =
      asked ? surface_.shape_of(grid_, surface, max_points, pacer) : SurfaceHull::Shape::kOther;
  if (shape == SurfaceHull::Shape::kHull) {
    triangles_.reserve(surface.size());
    for (std::size_t t = 0; t < surface.size(); ++t) triangles_.push_back(surface[t]);
    return triangles_;
  }
  if (shape == SurfaceHull::Shape::kOther) {
    if (const auto first = grid_.first_tetrahedron(pacer)) quickhull(*first, max_points, tolerance, pacer);
    return triangles_;
  }
  surface_.list_sharp(number_);
  pacer.step(number_.size());
  grid_.keep(number_);
  if (const auto first = grid_.first_tetrahedron(pacer)) quickhull(*first, max_points, tolerance, pacer);
  for (auto& t : triangles_) t = {number_[t[0]], number_[t[1]], number_[t[2]]};
  return triangles_;
}

}  // namespace fracture
