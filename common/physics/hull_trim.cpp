#include "common/physics/hull_trim.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/physics/convex_body.hpp"
#include "common/physics/hull_maker.hpp"

namespace fracture {
namespace {

/// Share of a hull's longest side: corners this near to a plane count as on it. A few steps of the floats of hulls.
constexpr double kOnThePlane = 0x1p-20;

struct TrimScratch {
  ConvexBody body;
  ConvexHullBuilder builder;
  std::vector<Vec3f> corners;
  std::vector<std::uint32_t> index;
  std::size_t bytes() const { return body.bytes() + builder.bytes() + bytes_of_vectors(corners, index); }
  void release() {
    body.release();
    builder.release();
    release_vectors(corners, index);
  }
};

Box box_of(const CollisionHull& hull) {
  Box box;
  for (const Vec3f& p : hull.points) box.add(to_double(p));
  return box;
}

/// Least coordinate, in this direction, of the contact's pieces. They are on the measured part, which receives the other.
double beginning(const ContactGraph& graph, std::size_t contact, const Vec3d& direction, Pacer& pacer) {
  double least = HUGE_VAL;
  for (std::uint32_t k = graph.first_piece[contact]; k < graph.first_piece[contact + 1]; ++k) {
    pacer.step();
    for (const Vec3d& corner : graph.pieces[k].corners) least = std::fmin(least, dot(direction, corner));
  }
  return least;
}

void trim_hull(CollisionHull& hull, const Vec3d& pivot, std::span<const TrimPlane> planes,
               const Execution& execution) {
  double whole = hull.untrimmed;
  for (const TrimPlane& plane : planes) {
    const double offset = plane.offset - dot(plane.normal, pivot);
    if (std::none_of(hull.points.begin(), hull.points.end(),
                     [&](const Vec3f& p) { return dot(plane.normal, to_double(p)) > offset; }))
      continue;
    Box box;
    for (const Vec3f& p : hull.points) box.add(pivot + to_double(p));
    if (!box.intersects(plane.other)) continue;
    if (whole == 0) whole = volume_within(hull.points, hull.triangles);
    CollisionHull rest = trimmed(hull, plane.normal, offset, execution);
    if (rest.points.empty()) continue;
    const double share = volume_within(rest.points, rest.triangles) / whole;
    if (!(share >= kLeastShareAtContacts)) continue;
    keep_trimmed(hull, std::move(rest), whole);
  }
}

}  // namespace

CollisionHull trimmed(const CollisionHull& hull, const Vec3d& normal, double offset,
                      const Execution& execution) {
  TrimScratch& s = thread_scratch<TrimScratch>();
  s.body.set(hull.points, hull.triangles);
  s.body.cut(normal, offset, kOnThePlane * box_of(hull).longest_side());
  s.corners.clear();
  for (const Vec3d& p : s.body.corners())
    s.corners.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  // Rebuilt, because coplanar triangles of the hull may leave several corners on one edge of the cut.
  const ConvexHullBuilder::Triangles& triangles = s.builder.build(s.corners, kMaxHullPoints, execution);
  if (triangles.empty()) return {};
  return compact(s.corners, triangles, s.index);
}

void keep_trimmed(CollisionHull& hull, CollisionHull part, double volume) {
  const double before = hull.untrimmed > 0 ? hull.untrimmed : volume;
  hull = std::move(part);
  hull.untrimmed = before;
}

double least_share(std::span<const CollisionHull> hulls) {
  double least = 1;
  for (const CollisionHull& hull : hulls)
    if (hull.untrimmed > 0)
      least = std::fmin(least, volume_within(hull.points, hull.triangles) / hull.untrimmed);
  return least;
}

ContactPlanes::ContactPlanes(const Solid& solid, const Execution& execution) {
  if (!solid.contacts) return;
  const ContactGraph& graph = *solid.contacts;
  Pacer pacer(execution);
  std::vector<std::pair<std::uint32_t, TrimPlane>> of_part;
  for (std::size_t k = 0; k < graph.contacts.size(); ++k) {
    pacer.step();
    const Contact& c = graph.contacts[k];
    if (c.kind != ContactKind::kOverlapping || c.measure != ContactMeasure::kInside) continue;
    const std::uint32_t receiving = c.of_b ? c.b : c.a, entering = c.of_b ? c.a : c.b;
    const Vec3d inwards = (c.of_b ? 1.0 : -1.0) * c.normal;
    const double first = beginning(graph, k, inwards, pacer);
    if (std::isfinite(first))
      of_part.push_back({entering, {inwards, first - kHullInset, solid.parts[receiving].box}});
  }
  if (of_part.empty()) return;
  std::stable_sort(of_part.begin(), of_part.end(),
                   [](const auto& x, const auto& y) { return x.first < y.first; });
  first_.assign(solid.parts.size() + 1, 0);
  for (const auto& [part, plane] : of_part) {
    pacer.step();
    planes_.push_back(plane);
    ++first_[part + 1];
  }
  for (std::size_t p = 0; p < solid.parts.size(); ++p) first_[p + 1] += first_[p];
}

void trim_at_contacts(const FragmentSet& set, const Solid& solid, CollisionHulls& hulls,
                      const Execution& execution) {
  const ContactPlanes planes(solid, execution);
  if (planes.empty()) return;
  parallel_for(execution, set.fragments.size(), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      FragmentHulls& of_fragment = hulls.of_fragment[k];
      const Fragment& f = set.fragments[k];
      const std::span<const TrimPlane> here = planes.of(f.part);
      // Pieces of several parts in one fragment overlap because they belong together.
      if (of_fragment.seen_contacts || here.empty() || !f.part_cells.empty()) continue;
      of_fragment.seen_contacts = true;
      for (CollisionHull& hull : of_fragment.hulls) {
        execution.poll();
        trim_hull(hull, f.pivot, here, execution);
      }
    }
  });
}

}  // namespace fracture
