#include "common/contacts/near_triangles.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/stamped_map.hpp"
#include "common/bvh/triangle_distance.hpp"
#include "common/contacts/vertex_windings.hpp"

namespace fracture::contacts_detail {

Box PartSurfaces::bounds_of(std::uint32_t triangle) const {
  const auto& v = solid_.triangles[triangle];
  const Vec3f &p = solid_.positions[v[0]], &q = solid_.positions[v[1]], &r = solid_.positions[v[2]];
  return {{std::min({p.x, q.x, r.x}), std::min({p.y, q.y, r.y}), std::min({p.z, q.z, r.z})},
          {std::max({p.x, q.x, r.x}), std::max({p.y, q.y, r.y}), std::max({p.z, q.z, r.z})}};
}

PartSurfaces::PartSurfaces(const Solid& solid, const Execution& execution)
    : solid_(solid),
      begin_(solid.parts.size() + 1, 0),
      trees_(solid.parts.size()),
      cores_(solid.parts.size()) {
  Pacer pacer(execution);
  pacer.each(0, solid.part.size(), [&](std::size_t t) { ++begin_[solid.part[t] + 1]; });
  for (std::size_t p = 1; p < begin_.size(); ++p) begin_[p] += begin_[p - 1];
  std::uint64_t in_trees = 0;
  for (std::uint32_t p = 0; p < solid.parts.size(); ++p)
    if (triangles_of(p) > kSmallPart) in_trees += triangles_of(p);
  execution.made(Product::kSurfaceTriangles, in_trees);
  std::vector<Box> boxes;
  for (std::uint32_t p = 0; p < solid.parts.size(); ++p) {
    pacer.step();
    if (triangles_of(p) <= kSmallPart) continue;
    boxes.clear();
    boxes.reserve(triangles_of(p));
    pacer.each(begin_[p], begin_[p + 1],
               [&](std::size_t t) { boxes.push_back(bounds_of(static_cast<std::uint32_t>(t))); });
    trees_[p] = std::make_unique<BoxTree>(boxes, execution);
  }
}

const PartSurfaces::Core& PartSurfaces::core(std::uint32_t part, Pacer& pacer) const {
  LazyCore& lazy = cores_[part];
  std::call_once(lazy.once, [&] {
    Core made;
    const Vec3d middle = solid_.parts[part].box.center();
    made.center = to_double(
        Vec3f{static_cast<float>(middle.x), static_cast<float>(middle.y), static_cast<float>(middle.z)});
    made.nearest = HUGE_VAL;
    for (std::uint32_t t = begin_[part]; t < begin_[part + 1]; ++t) {
      pacer.step(16);
      const Corners its = corners(t);
      for (const Vec3d& p : its) made.farthest = std::max(made.farthest, length(p - made.center));
      made.nearest = distance_of_triangles({made.center, made.center, made.center}, its, made.nearest);
    }
    made.winding = winding_around(*this, part, made.center, Owner::kA, pacer);
    lazy.core = made;
  });
  return lazy.core;
}

NearTriangle NearPair::made_of(const PartSurfaces& surfaces, std::uint32_t triangle) const {
  NearTriangle made;
  made.triangle = triangle;
  made.corners = surfaces.corners(triangle);
  for (Vec3d& p : made.corners) p = p - origin;
  made.box = box_of(made.corners);
  const Vec3d across = cross(made.corners[1] - made.corners[0], made.corners[2] - made.corners[0]);
  const double size = length(across);
  made.area = 0.5 * size;
  if (size > 0) made.normal = (1 / size) * across;
  return made;
}

/// Fills `near` with the triangles of the part that are within reach of the other part's box.
void NearPair::gather_near(const PartSurfaces& surfaces, std::uint32_t part, std::uint32_t other,
                           std::vector<NearTriangle>& near, Pacer& pacer) const {
  near.clear();
  surfaces.each_near(part, widened(surfaces.solid().parts[other].box, reach), pacer,
                     [&](std::uint32_t t) { near.push_back(made_of(surfaces, t)); });
}

namespace {

/// Whether t is entirely on one side of the plane of s, farther from it than `reach`.
bool is_beyond(const NearTriangle& s, const NearTriangle& t, double reach) {
  const double u = dot(s.normal, t.corners[0] - s.corners[0]), v = dot(s.normal, t.corners[1] - s.corners[0]),
               w = dot(s.normal, t.corners[2] - s.corners[0]);
  return (u > reach && v > reach && w > reach) || (u < -reach && v < -reach && w < -reach);
}

}  // namespace

void NearPair::search(const PartSurfaces& surfaces, std::uint32_t searched, std::vector<NearTriangle>& found,
                      const std::vector<NearTriangle>& others, Pacer& pacer) {
  StampedMap& place_of = worker_map();
  place_of.next_epoch(surfaces.solid().triangles.size());
  found.clear();
  pairs.clear();
  for (std::uint32_t k = 0; k < others.size(); ++k) {
    const NearTriangle& other = others[k];
    surfaces.each_near(searched, widened(box_of(surfaces.corners(other.triangle)), reach), pacer,
                       [&](std::uint32_t t) {
                         std::uint32_t& place = place_of.slot(t);
                         if (place == StampedMap::kEmpty) {
                           place = static_cast<std::uint32_t>(found.size());
                           found.push_back(made_of(surfaces, t));
                         }
                         if (is_beyond(other, found[place], reach) || is_beyond(found[place], other, reach))
                           return;
                         pairs.push_back(searched == part_b ? std::array{k, place} : std::array{place, k});
                       });
  }
}

void NearPair::gather(const PartSurfaces& surfaces, const Execution& execution, Pacer& pacer) {
  whole = !surfaces.has_tree(part_a) && !surfaces.has_tree(part_b);
  if (whole) {
    gather_near(surfaces, part_a, part_b, a, pacer);
    gather_near(surfaces, part_b, part_a, b, pacer);
    return find_pairs(execution, pacer);
  }
  // If both parts are large, the part with the smaller box is searched, because fewer triangles of the
  // other part are near that box.
  const auto& parts = surfaces.solid().parts;
  const bool smaller_b = parts[part_b].box.longest_side() <= parts[part_a].box.longest_side();
  const bool search_b = surfaces.has_tree(part_b) && (smaller_b || !surfaces.has_tree(part_a));
  gather_near(surfaces, search_b ? part_a : part_b, search_b ? part_b : part_a, search_b ? a : b, pacer);
  search(surfaces, search_b ? part_b : part_a, search_b ? b : a, search_b ? a : b, pacer);
}

void NearPair::gather_whole(const PartSurfaces& surfaces, const Execution& execution, Pacer& pacer) {
  if (whole) return;
  gather_near(surfaces, part_a, part_b, a, pacer);
  gather_near(surfaces, part_b, part_a, b, pacer);
  whole = true;
  find_pairs(execution, pacer);
}

void NearPair::find_pairs(const Execution& execution, Pacer& pacer) {
  constexpr std::size_t kFew = 4096;
  pairs.clear();
  if (a.empty() || b.empty()) return;
  if (a.size() * b.size() <= kFew) {
    for (std::uint32_t i = 0; i < a.size(); ++i) {
      const Box box = widened(a[i].box, reach);
      for (std::uint32_t k = 0; k < b.size(); ++k)
        if (box.intersects(b[k].box)) pairs.push_back({i, k});
    }
    pacer.step(a.size() * b.size() / 8);
    return;
  }
  std::vector<Box> boxes;
  boxes.reserve(b.size());
  for (const NearTriangle& t : b) boxes.push_back(t.box);
  const BoxTree tree(boxes, execution);
  for (std::uint32_t i = 0; i < a.size(); ++i)
    tree.each_overlapping(widened(a[i].box, reach), [&](std::uint32_t k) {
      pacer.step();
      if (!is_beyond(a[i], b[k], reach) && !is_beyond(b[k], a[i], reach)) pairs.push_back({i, k});
    });
}

}  // namespace fracture::contacts_detail
