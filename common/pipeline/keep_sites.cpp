#include "common/pipeline/keep_sites.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "common/bvh/box_tree.hpp"
#include "common/pipeline/convex_polygon.hpp"
#include "common/sites/arithmetic.hpp"
#include "common/sites/sites.hpp"

namespace fracture {
namespace {

/// Distance of neighbouring sites on a facet / distance of neighbouring sites of the pattern.
constexpr double kFiner = 0.6;
constexpr double kMostOnFacets = 2048;
/// A region has a single site if its corners are within this many spacings of the site.
constexpr double kOneSite = 1.2;
/// Distance of a site from its facet / radius of the polygon that it covers.
constexpr double kBehind = 0.6;
/// Least distance of a site from the other facets / its distance from its own.
constexpr double kFromOthers = 0.5;
constexpr double kRoundingSteps = 8;

/// Approximate distance of neighbouring sites, if `count` of them are in a solid of this volume and box. If the
/// solid is thinner than this, sites are next to each other in a plane or on a line.
double spacing_of(const Box& box, double volume, double count) {
  const Vec3d size = box.size();
  double sides[3] = {size.x, size.y, size.z};
  std::sort(sides, sides + 3);
  const double filled = std::fmin(1, volume / std::fmax(sides[0] * sides[1] * sides[2], 1e-300));
  const double in_space =
      sites_detail::power(std::fmin(1, filled * (sides[0] / sides[2]) * (sides[1] / sides[2]) / count),
                          1.0 / 3) *
      sides[2];
  if (in_space <= sides[0]) return in_space;
  const double in_plane = std::sqrt(filled * sides[1] * sides[2] / count);
  return in_plane <= sides[1] ? in_plane : filled * sides[2] / count;
}

/// The sites of one frame.
class FrameSites {
 public:
  FrameSites(const KeptSpace::Frame& frame, double spacing, const SiteLattice& lattice, Pacer& pacer)
      : frame_(frame), lattice_(lattice), pacer_(pacer) {
    const double wide = kFiner * spacing;
    bounds_ = {frame.box.min - Vec3d{wide, wide, wide}, frame.box.max + Vec3d{wide, wide, wide}};
    double area = 0;
    for (std::size_t f = 0; f < frame_.facets.size(); ++f) {
      polygons_.push_back(frame_.divides[f] ? polygon_of(f) : ConvexPolygon{});
      area += area_of(polygons_[f]);
    }
    size_ = std::fmax(kFiner * spacing, std::sqrt(area / kMostOnFacets));
    if (!place_one(kOneSite * spacing))
      for (std::size_t f = 0; f < frame_.facets.size(); ++f)
        if (!polygons_[f].empty()) place_on(f);
    mirror();
  }

  const std::vector<Vec3d>& inside() const { return inside_; }
  const std::vector<Vec3d>& outside() const { return outside_; }
  double reach() const { return reach_; }

 private:
  static double area_of(const ConvexPolygon& polygon) {
    Vec3d sum;
    for (std::size_t k = 2; k < polygon.size(); ++k)
      sum = sum + cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
    return 0.5 * length(sum);
  }

  /// The part of the facet near the solid.
  ConvexPolygon polygon_of(std::size_t f) {
    const KeptFacet& facet = frame_.facets[f];
    const Vec3d middle = bounds_.center() + facet.depth(bounds_.center()) * facet.normal;
    const auto [s, t] = sites_detail::across(facet.normal);
    ConvexPolygon polygon = square(middle, s, t, 2 * length(bounds_.size()));
    for (std::size_t other = 0; other < frame_.facets.size() && !polygon.empty(); ++other) {
      pacer_.step(8);
      if (other != f) clip(polygon, frame_.facets[other].normal, frame_.facets[other].offset, scratch_);
    }
    clip(polygon, bounds_, scratch_);
    if (polygon.size() < 3) polygon.clear();
    return polygon;
  }

  /// Places a single site in a region that is not larger than this.
  bool place_one(double most) {
    Vec3d sum;
    double corners = 0;
    for (const ConvexPolygon& polygon : polygons_)
      for (const Vec3d& p : polygon) {
        sum = sum + p;
        ++corners;
      }
    if (corners == 0) return false;
    const Vec3d site = lattice_.snap((1 / corners) * sum);
    double radius = 0, depth = HUGE_VAL;
    for (const ConvexPolygon& polygon : polygons_)
      for (const Vec3d& p : polygon) radius = std::fmax(radius, length(p - site));
    for (const KeptFacet& facet : frame_.facets) depth = std::fmin(depth, facet.depth(site));
    if (radius > most || depth < kRoundingSteps * lattice_.step) return false;
    inside_.push_back(site);
    reach_ = radius;
    return true;
  }

  /// Divides the facet into squares, and places a site behind each of them.
  void place_on(std::size_t f) {
    const Vec3d axes[2] = {sites_detail::across(frame_.facets[f].normal).u,
                           sites_detail::across(frame_.facets[f].normal).v};
    double low[2], step[2];
    int count[2];
    for (int k = 0; k < 2; ++k) {
      double high = -HUGE_VAL;
      low[k] = HUGE_VAL;
      for (const Vec3d& p : polygons_[f]) {
        low[k] = std::fmin(low[k], dot(p, axes[k]));
        high = std::fmax(high, dot(p, axes[k]));
      }
      count[k] = static_cast<int>(std::ceil(std::fmax(1, (high - low[k]) / size_ - 0.01)));
      step[k] = (high - low[k]) / count[k];
    }
    for (int i = 0; i < count[0]; ++i) {
      ConvexPolygon row = polygons_[f];
      if (i > 0) clip(row, -1.0 * axes[0], -(low[0] + i * step[0]), scratch_);
      if (i + 1 < count[0]) clip(row, axes[0], low[0] + (i + 1) * step[0], scratch_);
      for (int j = 0; j < count[1] && !row.empty(); ++j) {
        pacer_.step(16);
        ConvexPolygon cell = row;
        if (j > 0) clip(cell, -1.0 * axes[1], -(low[1] + j * step[1]), scratch_);
        if (j + 1 < count[1]) clip(cell, axes[1], low[1] + (j + 1) * step[1], scratch_);
        if (cell.size() >= 3) place_behind(f, cell);
      }
    }
  }

  void place_behind(std::size_t f, const ConvexPolygon& cell) {
    Vec3d middle;
    for (const Vec3d& p : cell) middle = middle + (1.0 / static_cast<double>(cell.size())) * p;
    double radius = 0;
    for (const Vec3d& p : cell) radius = std::fmax(radius, length(p - middle));
    for (double behind = kBehind * radius; behind > kRoundingSteps * lattice_.step; behind /= 2) {
      const Vec3d site = lattice_.snap(middle - behind * frame_.facets[f].normal);
      double others = HUGE_VAL;
      for (std::size_t other = 0; other < frame_.facets.size(); ++other)
        if (other != f) others = std::fmin(others, frame_.facets[other].depth(site));
      if (others < kFromOthers * behind) continue;
      inside_.push_back(site);
      for (const Vec3d& p : cell) reach_ = std::fmax(reach_, length(p - site));
      return;
    }
  }

  /// Adds the mirror image of each site at each facet that its cell meets.
  void mirror() {
    for (std::size_t k = 0; k < inside_.size(); ++k) {
      const Vec3d& a = inside_[k];
      near_.clear();
      pacer_.step(inside_.size() / 4);
      for (std::size_t other = 0; other < inside_.size(); ++other)
        if (other != k && length(inside_[other] - a) <= 2 * reach_) near_.push_back(other);
      for (std::size_t f = 0; f < frame_.facets.size(); ++f) {
        const KeptFacet& facet = frame_.facets[f];
        const double depth = facet.depth(a);
        if (polygons_[f].empty() || depth > reach_ || !meets(k, polygons_[f])) continue;
        outside_.push_back(lattice_.snap(a + 2 * depth * facet.normal));
      }
    }
  }

  /// Whether more than rounding of the polygon is in the cell of a site.
  bool meets(std::size_t k, ConvexPolygon polygon) {
    const Vec3d& a = inside_[k];
    const Vec3d wide{reach_, reach_, reach_};
    clip(polygon, Box{a - wide, a + wide}, scratch_);
    for (const std::size_t other : near_) {
      if (polygon.empty()) return false;
      pacer_.step(8);
      const Vec3d to = inside_[other] - a;
      const double far = length(to);
      clip(polygon, (1 / far) * to, dot((1 / far) * to, a) + 0.5 * far - kRoundingSteps * lattice_.step,
           scratch_);
    }
    return polygon.size() >= 3;
  }

  const KeptSpace::Frame& frame_;
  const SiteLattice& lattice_;
  Pacer& pacer_;
  Box bounds_;
  double size_ = 0, reach_ = 0;
  std::vector<ConvexPolygon> polygons_;  // per facet
  std::vector<Vec3d> inside_, outside_;
  std::vector<std::size_t> near_;
  ConvexPolygon scratch_;
};

Vec3d nearest_in(const Box& box, Vec3d p) {
  for (int a = 0; a < 3; ++a) p[a] = std::clamp(p[a], box.min[a], box.max[a]);
  return p;
}

/// Number of the nearest of the points.
class NearestPoint {
 public:
  NearestPoint(const std::vector<Vec3d>& points, const Execution& execution)
      : points_(points), tree_(boxes_of(points), execution) {}
  std::size_t of(const Vec3d& p) const {
    std::size_t best = 0;
    double least = HUGE_VAL;
    tree_.nearest(p, HUGE_VAL, 0, [&](std::uint32_t k) {
      const double far = length(points_[k] - p);
      if (far < least || (far == least && k < best)) {
        least = far;
        best = k;
      }
      return far;
    });
    return best;
  }

 private:
  static std::vector<Box> boxes_of(const std::vector<Vec3d>& points) {
    std::vector<Box> boxes;
    for (const Vec3d& p : points) boxes.push_back({p, p});
    return boxes;
  }
  const std::vector<Vec3d>& points_;
  BoxTree tree_;
};

/// The plan without the points that are too near the surface of the region.
class Merged {
 public:
  Merged(SitePlan& plan, bool grouped, bool keeps_numbers, const Execution& execution)
      : plan_(plan),
        grouped_(grouped),
        keeps_numbers_(keeps_numbers),
        before_(plan.points),
        groups_(plan.groups),
        bricks_(plan.bricks),
        nearest_(before_, execution),
        pacer_(execution) {
    if (groups_.empty()) {
      groups_.resize(before_.size());
      std::iota(groups_.begin(), groups_.end(), 0u);
    }
    for (const std::uint32_t g : groups_) kept_ = std::max(kept_, g + 1);
    plan_.points.clear();
    plan_.groups.clear();
    plan_.bricks.clear();
  }

  void keep(const KeptSpace& space, const std::vector<double>& reach, const CellMap& map) {
    for (std::size_t k = 0; k < before_.size(); ++k) {
      pacer_.step(8);
      const Vec3d& p = before_[k];
      const std::size_t frame = map.index_at(p);
      const double depth = space.depth(nearest_in(space.frames()[frame].box, p));
      const bool inside = space.holds(p);
      if (std::fabs(depth) >= reach[frame] && inside == (depth > 0)) {
        add(p, inside ? kept_ : groups_[k], inside || bricks_.empty() ? kNoIndex : bricks_[k]);
      } else if (keeps_numbers_) {
        moved_.push_back(plan_.points.size());
        add(p, kept_, kNoIndex);
      }
    }
  }
  void add_inside(const std::vector<Vec3d>& sites) {
    for (const std::size_t k : moved_)
      if (!sites.empty()) plan_.points[k] = sites[0];
    if (!sites.empty()) moved_.clear();
    for (const Vec3d& p : sites) add(p, kept_, kNoIndex);
  }
  void add_outside(const std::vector<Vec3d>& sites) {
    for (const Vec3d& p : sites) {
      pacer_.step(64);
      const std::size_t of = nearest_.of(p);
      add(p, groups_[of], bricks_.empty() ? kNoIndex : bricks_[of]);
    }
  }

 private:
  void add(const Vec3d& p, std::uint32_t group, std::uint32_t brick) {
    plan_.points.push_back(p);
    if (grouped_) plan_.groups.push_back(group);
    if (!bricks_.empty()) plan_.bricks.push_back(brick);
  }

  SitePlan& plan_;
  const bool grouped_, keeps_numbers_;
  const std::vector<Vec3d> before_;
  std::vector<std::uint32_t> groups_, bricks_;
  NearestPoint nearest_;
  Pacer pacer_;
  std::uint32_t kept_ = 0;
  std::vector<std::size_t> moved_;
};

}  // namespace

void add_keep_sites(const KeptSpace& space, const SeenSolid& seen, bool grouped, bool keeps_numbers,
                    SitePlan& plan, const Execution& execution) {
  const Solid& image = seen.seen();
  const SiteLattice lattice = site_lattice(image.box);
  const CellMap& map = seen.map();
  const std::size_t frames = space.frames().size();
  Pacer pacer(execution);
  std::vector<double> volume(frames, 0), count(frames, 0), reach(frames, 0);
  for (std::uint32_t p = 0; p < image.parts.size(); ++p)
    volume[frames > 1 ? static_cast<std::size_t>(&map.of_part(p) - map.frames().data()) : 0] +=
        image.parts[p].volume;
  for (const Vec3d& p : plan.points) {
    pacer.step();
    ++count[map.index_at(p)];
  }
  std::vector<FrameSites> sites;
  for (std::size_t f = 0; f < frames; ++f) {
    const KeptSpace::Frame& frame = space.frames()[f];
    static const KeptSpace::Frame nothing;
    const bool any = frame.meets && !frame.box.empty();
    sites.emplace_back(any ? frame : nothing,
                       any ? spacing_of(frame.box, volume[f], std::fmax(1, count[f])) : 0, lattice, pacer);
    reach[f] = sites[f].reach();
    plan.clearance = std::fmax(plan.clearance, reach[f]);
  }
  Merged merged(plan, grouped, keeps_numbers, execution);
  merged.keep(space, reach, map);
  for (const FrameSites& frame : sites) merged.add_inside(frame.inside());
  for (const FrameSites& frame : sites) merged.add_outside(frame.outside());
}

bool may_have_site(const KeptSpace& space, const Vec3d& image, double clearance) {
  return space.depth(nearest_in(space.at(image).box, image)) <= -clearance;
}

}  // namespace fracture
