#include "common/pipeline/keep_region.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/pipeline/convex_polygon.hpp"

namespace fracture {
namespace {

/// Squared distance from q to a convex polygon in the plane with this unit normal.
double distance2(const ConvexPolygon& polygon, const Vec3d& normal, const Vec3d& q) {
  double nearest = HUGE_VAL;
  int turns = 0;  // all to one side: the foot of q is inside
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3d a = polygon[k] - q, e = polygon[(k + 1) % polygon.size()] - polygon[k];
    const double ee = dot(e, e), t = ee > 0 ? std::clamp(-dot(a, e) / ee, 0.0, 1.0) : 0.0;
    const Vec3d p = a + t * e;
    nearest = std::min(nearest, dot(p, p));
    turns += dot(normal, cross(a, e)) >= 0 ? 1 : -1;
  }
  const double height = dot(normal, polygon[0] - q);
  return std::abs(turns) == static_cast<int>(polygon.size()) ? height * height : nearest;
}

/// Returns a region that contains every point that may move into the given one.
Region grown(Region region, const Movement& movement) {
  region.radius += movement.distance();
  constexpr std::array<Vec3d, 3> kAxes{Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec3d wide = movement.along(kAxes[axis]) * kAxes[axis];
    region.box.min = region.box.min - wide;
    region.box.max = region.box.max + wide;
  }
  return region;
}

/// Returns the bounding box of the box's image, including points that may move into it.
Box image_of(const Box& box, const CellMap::Frame& frame, double margin, const Movement& movement) {
  Box image;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d p = box.min;
    for (int a = 0; a < 3; ++a)
      if (corner >> a & 1) p[a] = box.max[a];
    image.add(frame.image(p));
  }
  Vec3d wide{margin, margin, margin};
  for (int a = 0; a < 3; ++a) wide[a] += movement.along(frame.matrix.rows[static_cast<std::size_t>(a)]);
  return {image.min - wide, image.max + wide};
}

class RegionWalk {
 public:
  /// Walks within the place of one frame of the diagram's map, if it has one.
  RegionWalk(const Region& region, const VoronoiDiagram& diagram, std::size_t frame, const Box& bounds,
             const Movement& movement, const Execution& execution)
      : region_(region),
        diagram_(diagram),
        margin_(1e-9 * bounds.longest_side()),
        execution_(execution),
        pacer_(execution) {
    Box wide;
    Box all = bounds;
    if (const CellMap& map = diagram.map()) {
      // Vertices of the image are rounded to float.
      wide = image_of(box_of(region), map.frames()[frame], 1e-6 * bounds.longest_side(), movement);
      region_.shape = Region::Shape::kBox;
      Box place = map.place_of(frame);
      const double off = 1e-6 * bounds.longest_side();
      place.min = place.min - Vec3d{off, off, off};
      place.max = place.max + Vec3d{off, off, off};
      all = common_of(all, place);
    } else {
      region_ = grown(region, movement);
      wide = box_of(region_);
    }
    limits_ = common_of(wide, all);
  }

  std::vector<SiteId> run() {
    for (int a = 0; a < 3; ++a)
      if (limits_.min[a] > limits_.max[a]) return {};
    Vec3d start = limits_.center();
    if (region_.shape == Region::Shape::kSphere) {
      for (int a = 0; a < 3; ++a) start[a] = std::clamp(region_.center[a], limits_.min[a], limits_.max[a]);
      if (length(start - region_.center) > region_.radius + margin_) return {};
    }
    std::vector<char> seen(diagram_.dual().site_count(), 0);
    std::vector<SiteId> found{diagram_.nearest(start, SiteId{0})};
    seen[found[0]] = 1;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const SiteId i = found[k];
      find_rings(i);
      std::size_t next = 0;  // the current neighbour's ring entries, which are in the order of the neighbours
      for (const Bisector& b : diagram_.bisectors(i)) {
        ring_.clear();
        for (; next < rings_.size() && rings_[next].first == b.neighbor; ++next)
          ring_.push_back(rings_[next].second);
        if (!diagram_.dual().is_corner(b.neighbor) && !seen[b.neighbor] && facet_meets(i, b)) {
          seen[b.neighbor] = 1;
          found.push_back(b.neighbor);
        }
      }
    }
    sort_with_polls(execution_, found.begin(), found.end());
    return found;
  }

 private:
  /// Collects, for each neighbour of cell i, ascending, the neighbours whose cells surround the facet
  /// between them.
  void find_rings(SiteId i) {
    rings_.clear();
    for (const TetId t : diagram_.tetrahedra(i)) {
      pacer_.step(32);
      for (const SiteId j : diagram_.dual().tets[t].v)
        for (const SiteId k : diagram_.dual().tets[t].v)
          if (j != i && k != i && j != k) rings_.emplace_back(j, k);
    }
    sort_with_polls(execution_, rings_.begin(), rings_.end());
    rings_.erase(std::unique(rings_.begin(), rings_.end()), rings_.end());
  }

  /// Whether the facet between i and a neighbour, with the ring in ring_, meets the region. Only the
  /// bisectors of the ring bound the facet.
  bool facet_meets(SiteId i, const Bisector& facet) {
    const double l = length(facet.u);
    const Vec3d n = (1 / l) * facet.u, middle = diagram_.site(i) + 0.5 * facet.u, center = limits_.center();
    const Vec3d foot = center - dot(n, center - middle) * n;
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (std::fabs(n[a]) < std::fabs(n[axis])) axis = a;
    Vec3d unit;
    unit[axis] = 1;
    Vec3d s = cross(n, unit);
    s = (1 / length(s)) * s;
    const Vec3d t = cross(n, s);
    const double reach = 2 * length(limits_.size()) + 4 * margin_;
    polygon_ = {foot - reach * s - reach * t, foot + reach * s - reach * t, foot + reach * s + reach * t,
                foot - reach * s + reach * t};
    for (int a = 0; a < 3 && !polygon_.empty(); ++a) {
      Vec3d normal;
      normal[a] = 1;
      clip(polygon_, normal, limits_.max[a] + margin_, scratch_);
      clip(polygon_, -1.0 * normal, margin_ - limits_.min[a], scratch_);
    }
    const auto bisectors = diagram_.bisectors(i);
    for (const SiteId neighbor : ring_) {
      if (polygon_.empty()) return false;
      pacer_.step(16 * polygon_.size());
      const Bisector& b = *std::lower_bound(bisectors.begin(), bisectors.end(), neighbor,
                                            [](const Bisector& x, SiteId site) { return x.neighbor < site; });
      clip(polygon_, b.u, b.half + dot(b.u, diagram_.site(i)) + margin_ * length(b.u), scratch_);
    }
    if (polygon_.empty()) return false;
    if (region_.shape == Region::Shape::kBox) return true;
    const double r = region_.radius + margin_;
    return distance2(polygon_, n, region_.center) <= r * r;
  }

  Region region_;
  const VoronoiDiagram& diagram_;
  const double margin_;
  const Execution& execution_;
  Pacer pacer_;
  Box limits_;  ///< the region's box within the bounds
  std::vector<std::pair<SiteId, SiteId>> rings_;
  std::vector<SiteId> ring_;
  ConvexPolygon polygon_, scratch_;
};

}  // namespace

std::vector<SiteId> cells_meeting(const Region& region, const VoronoiDiagram& diagram, const Box& bounds,
                                  const Execution& execution, std::span<const Movement> movements) {
  if (diagram.dual().site_count() == 0 || bounds.empty()) return {};
  const std::size_t frames = std::max<std::size_t>(1, diagram.map().frames().size());
  std::vector<SiteId> cells;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const Movement movement = movements.empty() ? Movement() : movements[frame];
    const std::vector<SiteId> found = RegionWalk(region, diagram, frame, bounds, movement, execution).run();
    cells.insert(cells.end(), found.begin(), found.end());
  }
  if (frames > 1) {
    sort_with_polls(execution, cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  }
  return cells;
}

}  // namespace fracture
