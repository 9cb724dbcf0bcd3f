#include "common/rough/refine.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "common/base/disjoint_sets.hpp"
#include "common/base/pacer.hpp"
#include "common/base/stamped_map.hpp"
#include "common/clip/ear_clipping.hpp"
#include "common/mesh/mesh.hpp"
#include "common/rough/collar.hpp"
#include "common/rough/core_lattice.hpp"
#include "common/rough/edge_splits.hpp"
#include "common/rough/shortest_triangulation.hpp"

namespace fracture {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Regions narrower than this share of an edge count as slivers, if they have at most kLongestSliver corners.
constexpr double kThin = 1e-3;
constexpr std::size_t kLongestSliver = 160;
/// Maximum share of a region's area in triangles that turn right: more than rounding causes.
constexpr double kMostFolded = 1e-3;
/// Number of steps across a region to which planar coordinates are rounded.
constexpr double kSteps = 1 << 23;

/// Refines one region after another; keeps its buffers in between.
class RegionRefiner {
 public:
  RegionRefiner(const VoronoiDiagram& diagram, const VertexPositions& positions, const EdgeSplits& splits,
                double length, const Execution& execution)
      : diagram_(diagram),
        positions_(positions),
        splits_(splits),
        length_(length),
        execution_(execution),
        pacer_(execution) {}

  /// Sets triangles(), as indices of known() followed by fresh(), and components().
  void refine(const CapRegion& region, std::span<const std::array<CutVertexId, 3>> old) {
    triangulate_anew(region, old);
    find_components();
  }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<CutVertexId>& known() const { return ids_; }
  const std::vector<Vec3d>& fresh() const { return fresh_; }
  /// Per triangle, the number of its connected component in the region, in the order of their first
  /// triangles. Empty if there is only one.
  const std::vector<std::uint32_t>& components() const { return component_; }

 private:
  void triangulate_anew(const CapRegion& region, std::span<const std::array<CutVertexId, 3>> old) {
    ids_.clear();
    collar_.clear();
    triangles_.clear();
    fresh_.clear();
    is_one_ = false;
    local_.next_epoch(positions_.points.size());
    gather_loops(old);
    if (ring_.empty()) return keep(old);  // all edges are shared
    flatten(region);
    const double area = planar_area();
    if (loop_begin_.size() == 2 && plane_.size() <= kLongestSliver && area < kThin * length_ * perimeter())
      return triangulate_shortest();
    if (area > 0) {
      core_.build(plane_, loop_begin_, length_, area, execution_);
      if (core_.points().empty() && ring_.size() == boundary_.size()) return keep(old);
      for (const Vec2d& p : core_.points()) fresh_.push_back(origin_ + p.x * across_ + p.y * up_);
      if (triangulate_with_core(area)) return;
    }
    triangles_.clear();
    fresh_.clear();
    for (const auto& t : old) {
      pacer_.step(64);
      split_sides(t);
    }
  }

  /// Keeps the triangles of a region that is not divided.
  void keep(std::span<const std::array<CutVertexId, 3>> old) {
    for (const auto& t : old) triangles_.push_back({local(t[0]), local(t[1]), local(t[2])});
  }

  // If loops cross, triangles of opposite orientation cancel, and the rest of the region may have several
  // components. Each component must become a region, because a region is shared by exactly two pieces
  // (Pieces::piece_of_cap).
  void find_components() {
    component_.clear();
    if (is_one_) return;
    joined_ = DisjointSets(ids_.size() + fresh_.size());
    for (const Triangle& t : triangles_) {
      joined_.unite(t[0], t[1]);
      joined_.unite(t[1], t[2]);
    }
    number_.assign(joined_.size(), kNoIndex);
    std::uint32_t count = 0;
    for (const Triangle& t : triangles_) {
      std::uint32_t& number = number_[joined_.find(t[0])];
      if (number == kNoIndex) number = count++;
      component_.push_back(number);
    }
    if (count < 2) component_.clear();
  }

  std::uint32_t local(CutVertexId v) {
    std::uint32_t& slot = local_.slot(v - positions_.first_constructed);
    if (slot == kNoIndex) {
      slot = static_cast<std::uint32_t>(ids_.size());
      ids_.push_back(v);
    }
    return slot;
  }

  /// The region's boundary with the vertices of the splits: edges that no other triangle uses in reverse,
  /// chained from vertex to vertex (the k-th edge that arrives continues with the k-th that leaves).
  void gather_loops(std::span<const std::array<CutVertexId, 3>> old) {
    edges_.clear();
    for (const auto& t : old)
      for (std::size_t k = 0; k < 3; ++k) {
        const CutVertexId a = t[k], b = t[(k + 1) % 3];
        edges_.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
      }
    sort_with_polls(execution_, edges_.begin(), edges_.end(), [](const Edge& x, const Edge& y) {
      return x.low != y.low ? x.low < y.low : x.high < y.high;
    });
    boundary_.clear();
    for (std::size_t k = 0; k < edges_.size();) {
      const Edge e = edges_[k];
      int balance = 0;
      for (; k < edges_.size() && edges_[k].low == e.low && edges_[k].high == e.high; ++k)
        balance += edges_[k].way;
      for (; balance > 0; --balance) boundary_.push_back({e.low, e.high});
      for (; balance < 0; ++balance) boundary_.push_back({e.high, e.low});
    }
    sort_with_polls(execution_, boundary_.begin(), boundary_.end());

    loop_begin_.assign(1, 0);
    used_.assign(boundary_.size(), 0);
    ring_.clear();
    for (std::size_t start = 0; start < boundary_.size(); ++start) {
      if (used_[start]) continue;
      const CutVertexId home = boundary_[start].first;
      for (std::size_t e = start;;) {
        used_[e] = 1;
        pacer_.step(16);
        const auto [from, to] = boundary_[e];
        ring_.push_back(from);
        splits_.between(from, to, ring_);
        if (to == home) break;
        e = static_cast<std::size_t>(
            std::lower_bound(boundary_.begin(), boundary_.end(), std::pair{to, CutVertexId{0}}) -
            boundary_.begin());
        while (e < boundary_.size() && boundary_[e].first == to && used_[e]) ++e;
        if (e == boundary_.size() || boundary_[e].first != to)
          throw InternalError("the boundary of a cap's triangles is open at vertex " + std::to_string(to));
      }
      loop_begin_.push_back(static_cast<std::uint32_t>(ring_.size()));
    }
  }

  /// Computes planar coordinates of the loops, relative to the region's least vertex, with axes derived from
  /// the facet's normal.
  void flatten(const CapRegion& region) {
    const Vec3d u = diagram_.facet_normal(region.lo, region.hi), normal = (1 / length(u)) * u;
    int axis = 0;  // the coordinate axis most perpendicular to the normal
    for (int a = 1; a < 3; ++a)
      if (std::fabs(normal[a]) < std::fabs(normal[axis])) axis = a;
    Vec3d e;
    e[axis] = 1;
    e = e - normal[axis] * normal;
    across_ = (1 / length(e)) * e;
    up_ = cross(normal, across_);
    loop_.clear();
    for (const CutVertexId v : ring_) loop_.push_back(local(v));
    flat_.clear();
    for (const CutVertexId v : ids_) flat_.push_back(positions_.points[v - positions_.first_constructed]);
    origin_ = *std::min_element(flat_.begin(), flat_.end(), lexicographic_less);
    plane_.clear();
    for (const std::uint32_t k : loop_) {
      const Vec3d d = flat_[k] - origin_;
      plane_.push_back({dot(d, across_), dot(d, up_)});
    }
    Vec2d low = plane_[0], high = plane_[0];
    for (const Vec2d& p : plane_) {
      low = {std::fmin(low.x, p.x), std::fmin(low.y, p.y)};
      high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y)};
    }
    low_ = low;
    const double extent = std::fmax(high.x - low.x, high.y - low.y);
    step_ = extent > 0 ? extent / kSteps : 1;
  }

  double planar_area() const {
    double twice = 0;
    for (std::size_t l = 0; l + 1 < loop_begin_.size(); ++l)
      for (std::uint32_t k = loop_begin_[l]; k < loop_begin_[l + 1]; ++k) {
        const Vec2d &p = plane_[k], &q = plane_[k + 1 < loop_begin_[l + 1] ? k + 1 : loop_begin_[l]];
        twice += p.x * q.y - p.y * q.x;
      }
    return 0.5 * twice;
  }

  double perimeter() const {
    double sum = 0;
    for (std::size_t k = 0; k < plane_.size(); ++k)
      sum += std::sqrt(square_distance(plane_[k], plane_[(k + 1) % plane_.size()]));
    return sum;
  }

  void triangulate_shortest() {
    for (const Triangle& t : shortest_.build(plane_, pacer_))
      triangles_.push_back({loop_[t[0]], loop_[t[1]], loop_[t[2]]});
  }

  LatticePoint rounded(const Vec2d& p) const {
    return {static_cast<std::int64_t>(std::nearbyint((p.x - low_.x) / step_)),
            static_cast<std::int64_t>(std::nearbyint((p.y - low_.y) / step_))};
  }

  /// Returns false, with an unspecified state, if the loops do not nest (surfaces that cross themselves).
  bool triangulate_with_core(double area) {
    // Corners of the collar: the loops in order, then the rim of the core.
    corner_.assign(loop_.begin(), loop_.end());
    collar_begin_ = loop_begin_;
    const auto known = static_cast<std::uint32_t>(ids_.size());
    for (std::size_t l = 0; l + 1 < core_.rim_begin().size(); ++l) {
      for (std::uint32_t k = core_.rim_begin()[l]; k < core_.rim_begin()[l + 1]; ++k)
        corner_.push_back(known + core_.rim()[k]);
      collar_begin_.push_back(static_cast<std::uint32_t>(corner_.size()));
    }
    collar_points_.clear();
    for (std::size_t k = 0; k < loop_.size(); ++k) collar_points_.push_back(rounded(plane_[k]));
    for (const std::uint32_t r : core_.rim()) collar_points_.push_back(rounded(core_.points()[r]));
    if (!collar_.build(collar_points_, collar_begin_, loop_begin_.size() - 1, execution_)) return false;
    double folded = 0;  // twice the area of triangles that turn right, because a loop may cross itself
    for (const auto& [p, q, r] : collar_.triangles())
      folded -= std::fmin(0, orient2d(collar_points_[p], collar_points_[q], collar_points_[r]));
    if (folded * step_ * step_ > 2 * kMostFolded * area) return false;
    for (const Triangle& t : collar_.triangles())
      triangles_.push_back({corner_[t[0]], corner_[t[1]], corner_[t[2]]});
    for (const Triangle& t : core_.triangles())
      triangles_.push_back({known + t[0], known + t[1], known + t[2]});
    is_one_ = loop_begin_.size() < 3 && collar_.regions() < 2;
    return true;
  }

  // A side is split in the same way in every triangle, so no gap can open. If the surface crosses itself, a
  // triangle may turn right and would have no ear, so its mirror image is divided instead.
  void split_sides(const std::array<CutVertexId, 3>& t) {
    const auto in_plane = [&](CutVertexId v) {
      const Vec3d d = positions_.points[v - positions_.first_constructed] - origin_;
      return rounded({dot(d, across_), dot(d, up_)});
    };
    const bool mirrored = orient2d(in_plane(t[0]), in_plane(t[1]), in_plane(t[2])) < 0;
    ring_.clear();
    for (const std::size_t k : {0, 1, 2}) {
      ring_.push_back(t[k]);
      splits_.between(t[k], t[(k + 1) % 3], ring_);
    }
    std::vector<LatticePoint> points;
    for (const CutVertexId v : ring_) points.push_back(in_plane(v));
    ring_local_.resize(ring_.size());
    std::iota(ring_local_.begin(), ring_local_.end(), 0u);
    if (mirrored) std::reverse(ring_local_.begin(), ring_local_.end());
    std::vector<Triangle> cut;
    clip_ears(points, ring_local_, cut);
    for (const auto& [a, b, c] : cut)
      triangles_.push_back({local(ring_[a]), local(ring_[mirrored ? c : b]), local(ring_[mirrored ? b : c])});
  }

  struct Edge {
    CutVertexId low, high;
    int way;
  };
  const VoronoiDiagram& diagram_;
  const VertexPositions& positions_;
  const EdgeSplits& splits_;
  const double length_;
  const Execution& execution_;
  Pacer pacer_;
  StampedMap& local_ = worker_map();
  std::vector<Edge> edges_;
  std::vector<std::pair<CutVertexId, CutVertexId>> boundary_;
  std::vector<char> used_;
  std::vector<CutVertexId> ring_;                 // the loops, one after the other
  std::vector<std::uint32_t> loop_, loop_begin_;  // indices into the local vertices
  Vec3d origin_, across_, up_;
  std::vector<Vec3d> flat_;   // per known vertex
  std::vector<Vec2d> plane_;  // per corner of the loops
  Vec2d low_;
  double step_ = 1;
  CoreLattice core_;
  ShortestTriangulation shortest_;
  std::vector<std::uint32_t> corner_, collar_begin_, ring_local_;
  std::vector<LatticePoint> collar_points_;
  Collar collar_;
  std::vector<CutVertexId> ids_;
  std::vector<Vec3d> fresh_;
  std::vector<Triangle> triangles_;
  bool is_one_ = false;  // known to be a single component
  DisjointSets joined_;
  std::vector<std::uint32_t> number_, component_;
};

}  // namespace

void refine_caps(const VoronoiDiagram& diagram, const Winding& winding, double length,
                 const RefinedCaps& which, Caps& caps, VertexPositions& positions,
                 const Execution& execution) {
  const auto& wanted = which.wanted;
  const EdgeSplits splits(winding, length, wanted, which.plain, positions, execution);
  struct Refined {
    std::vector<Triangle> triangles;
    std::vector<CutVertexId> known;
    std::vector<Vec3d> fresh;
    std::vector<std::uint32_t> components;
  };
  std::vector<Refined> refined(caps.regions.size());
  parallel_for(execution, refined.size(), 8, [&](std::size_t begin, std::size_t end) {
    RegionRefiner refiner(diagram, positions, splits, length, execution);
    for (std::size_t r = begin; r < end; ++r) {
      const CapRegion& region = caps.regions[r];
      if (!wanted(region.lo, region.hi)) continue;
      refiner.refine(region, {caps.triangles.data() + region.first_triangle, region.triangle_count});
      execution.made(Product::kCapTriangles, refiner.triangles().size());
      refined[r] = {refiner.triangles(), refiner.known(), refiner.fresh(), refiner.components()};
    }
  });

  std::vector<std::array<CutVertexId, 3>> triangles;
  std::vector<CapRegion> regions;
  Pacer pacer(execution);
  for (std::size_t r = 0; r < refined.size(); ++r) {
    const Refined& now = refined[r];
    const CapRegion& before = caps.regions[r];
    pacer.step(1 + now.triangles.size() + now.fresh.size());
    const auto begin_region = [&] {
      regions.push_back(before);
      regions.back().first_triangle = static_cast<std::uint32_t>(triangles.size());
      regions.back().triangle_count = 0;
    };
    begin_region();
    if (!wanted(before.lo, before.hi)) {
      const auto from = caps.triangles.begin() + before.first_triangle;
      triangles.insert(triangles.end(), from, from + before.triangle_count);
      regions.back().triangle_count = before.triangle_count;
      continue;
    }
    const auto known = static_cast<std::uint32_t>(now.known.size());
    const std::size_t first = positions.first_constructed + positions.points.size();
    for (const Vec3d& p : now.fresh) append_vertex(positions, p);
    std::vector<std::uint32_t> order(now.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto component = [&](std::uint32_t t) { return now.components.empty() ? 0 : now.components[t]; };
    if (!now.components.empty())
      std::stable_sort(order.begin(), order.end(),
                       [&](std::uint32_t s, std::uint32_t t) { return component(s) < component(t); });
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (k > 0 && component(order[k]) != component(order[k - 1])) begin_region();
      std::array<CutVertexId, 3> ids{};
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t v = now.triangles[order[k]][corner];
        ids[corner] = v < known ? now.known[v] : CutVertexId{first + (v - known)};
      }
      triangles.push_back(ids);
      ++regions.back().triangle_count;
    }
  }
  caps.regions = std::move(regions);
  caps.triangles = std::move(triangles);
  clear_with_polls(execution, refined);
}

}  // namespace fracture
