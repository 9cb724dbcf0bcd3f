// The Voronoi diagram, derived from its dual, the Delaunay tetrahedralization, in flat arrays for a clipper.
//
//   tetrahedron -> Voronoi vertex   facet of a tetrahedron -> Voronoi edge   edge -> Voronoi facet   site ->
//   cell
//
// Nothing is constructed here: facets, edges and vertices stay symbolic (tuples of sites). The planes are
// doubles with an error bound, and are used only as a filter before the exact side predicates.
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
  /// `box` must contain every point that is ever queried (the solid's box). With a map, the diagram is that
  /// of the solid's image: sites, box and queried points are images. Throws Interrupted. Cells with more than
  /// `many` neighbours get a Neighborhood, which queries use instead of all bisectors. `many` affects only
  /// the cost.
  VoronoiDiagram(const Tetrahedralization& tetrahedralization, const Box& box, const CellMap& map = {},
                 const Execution& execution = kUninterrupted, std::size_t many = kManyNeighbors);
  /// The diagram of a part of a tetrahedralization. Only the cells in `cells` (per site) have all their
  /// tetrahedra; bisectors and tetrahedra of other cells must not be requested.
  VoronoiDiagram(const Tetrahedralization& part, const std::vector<char>& cells, const Box& box,
                 const CellMap& map, const Execution& execution, std::size_t many = kManyNeighbors);

  const CellMap& map() const { return map_; }
  /// Direction of the normal of facet (i, j), from i to j, in the frame of the solid; not a unit vector.
  Vec3d facet_normal(SiteId i, SiteId j) const {
    const Vec3d u = site(j) - site(i);
    return map_ ? map_.at(site(i)).matrix.transposed_times(u) : u;
  }

  const Tetrahedralization& dual() const { return *dual_; }
  const Vec3d& site(SiteId s) const { return dual_->points[s]; }
  /// The cells that share a facet with cell i, ascending by site id; includes corners of the big tetrahedron.
  std::span<const Bisector> bisectors(SiteId i) const {
    return {bisectors_.data() + bisector_begin_[i], bisector_begin_[i + 1] - bisector_begin_[i]};
  }
  /// The tetrahedra at site i (the Voronoi vertices of its cell).
  std::span<const TetId> tetrahedra(SiteId i) const {
    return {tets_.data() + tet_begin_[i], tet_begin_[i + 1] - tet_begin_[i]};
  }

  /// The computed value of the bisector at q, for callers that compare it with `error` themselves.
  double value(SiteId i, const Bisector& bisector, const Vec3d& q) const {
    const Vec3d& p = site(i);
    return bisector.half -
           (bisector.u.x * (q.x - p.x) + bisector.u.y * (q.y - p.y) + bisector.u.z * (q.z - p.z));
  }
  /// +1 if q is closer to site i, -1 if it is closer to the neighbour; exact (exact::side1).
  int side(SiteId i, const Bisector& bisector, const Vec3d& q) const;
  /// State that nearest() keeps from point to point.
  struct Walk {
    /// The cell with many neighbours in which the last point was found. The next point is probably near it.
    SiteId cell = kNoSite;
    std::uint32_t facet = 0;      ///< index into bisectors(cell)
    std::uint64_t looked_at = 0;  ///< number of bisectors tested so far
  };
  /// Returns the site whose cell contains q, by a greedy walk from `start`. Exact. Takes about one step if
  /// `start` is near; if it is far, a tree of all sites shortens the walk. `walk` makes queries faster for
  /// many points near each other.
  SiteId nearest(const Vec3d& q, SiteId start, Walk& walk) const;
  SiteId nearest(const Vec3d& q, SiteId start) const {
    Walk walk;
    return nearest(q, start, walk);
  }

  /// Testing this many takes about as long as walking from facet to facet.
  static constexpr std::size_t kManyNeighbors = 64;
  bool has_many_neighbors(SiteId i) const { return bisector_begin_[i + 1] - bisector_begin_[i] > many_; }
  const Neighborhood& neighborhood(SiteId i) const;
  /// For a cell i with many neighbours: calls visit(bisector, squared distance of its neighbour from q) for
  /// the neighbours in a ball about q, usually nearer ones first. `visit` returns the new squared radius. A
  /// point x is beyond a bisector only if the neighbour is at least as near to x as site i. So the ball about
  /// q through site i, enlarged by the maximum distance between q and x (reach2), contains all bisectors that
  /// x is beyond.
  template <class Visit>
  void visit_near(SiteId i, const Vec3d& q, double radius2, const Visit& visit) const {
    const Bisector* all = bisectors_.data() + bisector_begin_[i];
    neighborhood(i).tree.visit_near(
        q, radius2, [&](std::uint32_t k, double distance2) { return visit(all[k], distance2); });
  }
  /// The squared radius of the ball about q through site i, for points x with |x - q| <= off.
  double reach2(SiteId i, const Vec3d& q, double off = 0) const {
    // Each difference, product and sum here and in the tree has a relative error of 2^-53.
    const Vec3d d = q - site(i);
    const double r = std::sqrt(dot(d, d)) + 2 * off;
    return r * r * (1 + 0x1.0p-45);
  }

  struct Facet {
    TetId tet;
    int face;  ///< opposite vertex `face` of `tet`
  };
  /// Returns the Delaunay facet (i, j, k) in one of its two forms. Throws InternalError if there is none.
  /// Turns around the edge (i, j) or (i, k) that has fewer tetrahedra. If each facet of a cell is requested
  /// once, the total cost is linear in their number (Chiba & Nishizeki 1985: the sum, over the edges of a
  /// planar graph, of the lesser degree of their ends).
  Facet find_facet(SiteId i, SiteId j, SiteId k) const;

 private:
  /// A tree of all sites, built once long walks have taken about as much time as building it takes.
  struct AllSites {
    std::atomic<std::uint64_t> steps{0};  ///< steps of long walks so far
    std::once_flag once;
    std::optional<SiteTree> tree;
  };
  void build(const Box& box, const std::vector<char>* cells, const Execution& execution);
  void add_neighborhood(SiteId i);
  /// Returns a neighbour that is closer to q than i, usually the closest; kNoSite if there is none.
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
  std::vector<Neighborhood> neighborhoods_;  // for cells with many neighbours, ascending by site
  std::unique_ptr<AllSites> all_sites_;
};

}  // namespace fracture
