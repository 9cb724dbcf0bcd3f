// The Voronoi diagram read off its dual, the Delaunay tetrahedralization: what a clipper asks of it, in flat
// arrays.
//
//   tetrahedron -> Voronoi vertex   facet of a tetrahedron -> Voronoi edge   edge -> Voronoi facet   site ->
//   cell
//
// Nothing is constructed here: facets, edges and vertices stay symbolic (tuples of sites); the planes are
// doubles with an error bound and serve only as filter in front of the exact side predicates.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "common/base/cell_map.hpp"
#include "common/base/execution.hpp"
#include "common/base/vec.hpp"
#include "common/delaunay/tetrahedralization.hpp"
#include "common/voronoi/neighborhood.hpp"

namespace fracture {

class VoronoiDiagram {
 public:
  /// `box` must contain every point that is ever asked about (the solid's box). With a map the diagram is
  /// that of the solid's image: sites, box and every point asked about are images. Throws Interrupted.
  /// Cells of more than `many` neighbours have a Neighborhood, and what looks at the bisectors of one asks
  /// that. It decides the cost alone.
  VoronoiDiagram(const Tetrahedralization& tetrahedralization, const Box& box, const CellMap& map = {},
                 const Execution& execution = kUninterrupted, std::size_t many = kManyNeighbors);
  /// Of a part of a tetrahedralization: only the cells in `cells` (per site) have all their tetrahedra, and of no
  /// others may be asked for bisectors or tetrahedra.
  VoronoiDiagram(const Tetrahedralization& part, const std::vector<char>& cells, const Box& box,
                 const CellMap& map, const Execution& execution, std::size_t many = kManyNeighbors);

  const CellMap& map() const { return map_; }
  /// Direction of the normal of facet (i, j), from i to j, in the frame of the solid; not of unit length.
  Vec3d facet_normal(SiteId i, SiteId j) const {
    const Vec3d u = site(j) - site(i);
    return map_ ? map_.at(site(i)).matrix.transposed_times(u) : u;
  }

  const Tetrahedralization& dual() const { return *dual_; }
  const Vec3d& site(SiteId s) const { return dual_->points[s]; }
  /// The cells that share a facet with cell i, ascending by site id; corners of the big tetrahedron included.
  std::span<const Bisector> bisectors(SiteId i) const {
    return {bisectors_.data() + bisector_begin_[i], bisector_begin_[i + 1] - bisector_begin_[i]};
  }
  /// The tetrahedra at site i (the Voronoi vertices of its cell).
  std::span<const TetId> tetrahedra(SiteId i) const {
    return {tets_.data() + tet_begin_[i], tet_begin_[i + 1] - tet_begin_[i]};
  }

  /// The bisector's value at q as computed, for callers that compare against `error` themselves.
  double value(SiteId i, const Bisector& bisector, const Vec3d& q) const {
    const Vec3d& p = site(i);
    return bisector.half -
           (bisector.u.x * (q.x - p.x) + bisector.u.y * (q.y - p.y) + bisector.u.z * (q.z - p.z));
  }
  /// +1 when q is closer to site i, -1 when closer to the neighbour; exact (exact::side1).
  int side(SiteId i, const Bisector& bisector, const Vec3d& q) const;
  /// What nearest() keeps from point to point.
  struct Walk {
    /// Where the last point was seen in a cell of many neighbours; the next one is probably near it.
    SiteId cell = kNoSite;
    std::uint32_t facet = 0;      ///< index into bisectors(cell)
    std::uint64_t looked_at = 0;  ///< bisectors, so far
  };
  /// The site whose cell holds q, by a greedy walk from `start`: exact. About one step when `start` is near;
  /// where it is far, a tree of all sites cuts the walk short. `walk` makes it faster for many points near
  /// each other.
  SiteId nearest(const Vec3d& q, SiteId start, Walk& walk) const;
  SiteId nearest(const Vec3d& q, SiteId start) const {
    Walk walk;
    return nearest(q, start, walk);
  }

  /// To look at all of so many takes about as long as to walk from facet to facet.
  static constexpr std::size_t kManyNeighbors = 64;
  bool has_many_neighbors(SiteId i) const { return bisector_begin_[i + 1] - bisector_begin_[i] > many_; }
  const Neighborhood& neighborhood(SiteId i) const;
  /// For such a cell i: calls visit(bisector, squared distance of its neighbour from q) for the neighbours in
  /// a ball about q, nearer ones mostly first. `visit` returns the squared radius from then on. A point x is
  /// beyond a bisector only if the neighbour is no farther from it than site i, so the ball about q through
  /// site i, widened by what q may differ from x (reach2), has all bisectors beyond which x lies.
  template <class Visit>
  void visit_near(SiteId i, const Vec3d& q, double radius2, const Visit& visit) const {
    const Bisector* all = bisectors_.data() + bisector_begin_[i];
    neighborhood(i).tree.visit_near(
        q, radius2, [&](std::uint32_t k, double distance2) { return visit(all[k], distance2); });
  }
  /// The squared radius of the ball about q through site i, for points x with |x - q| <= off.
  double reach2(SiteId i, const Vec3d& q, double off = 0) const {
    // Each difference, product and sum here and in the tree is off by 2^-53 relative.
    const Vec3d d = q - site(i);
    const double r = std::sqrt(dot(d, d)) + 2 * off;
    return r * r * (1 + 0x1.0p-45);
  }

  struct Facet {
    TetId tet;
    int face;  ///< opposite vertex `face` of `tet`
  };
  /// The Delaunay facet (i, j, k), one of the two ways to name it. Throws InternalError when there is none.
  /// Turns around the shorter one of the edges (i, j) and (i, k): as often as the facets of one cell are
  /// asked for, each once, that is linear in their number (Chiba & Nishizeki 1985: the sum over the edges of
  /// a planar graph of the lesser degree of their ends).
  Facet find_facet(SiteId i, SiteId j, SiteId k) const;

 private:
  /// A tree of all sites, made when long walks have taken about as much time as it takes.
  struct AllSites {
    std::atomic<std::uint64_t> steps{0};  ///< of long walks, so far
    std::once_flag once;
    std::optional<SiteTree> tree;
  };
  void build(const Box& box, const std::vector<char>* cells, const Execution& execution);
  void add_neighborhood(SiteId i);
  /// A neighbour to which q is closer than to i, mostly the closest; kNoSite when there is none.
  SiteId closer_neighbor(const Vec3d& q, SiteId i, Walk& walk) const;
  SiteId closer_of_many(const Vec3d& q, SiteId i, Walk& walk) const;
  SiteId roughly_nearest(const Vec3d& q) const;
  const Bisector* find_bisector(SiteId i, SiteId j) const;

  const Tetrahedralization* dual_;
  CellMap map_;
  std::size_t many_;
  std::vector<std::uint32_t> bisector_begin_, tet_begin_;
  std::vector<Bisector> bisectors_;
  std::vector<TetId> tets_;
  std::vector<Neighborhood> neighborhoods_;  // of cells of many neighbours, ascending by site
  std::unique_ptr<AllSites> all_sites_;
};

}  // namespace fracture
