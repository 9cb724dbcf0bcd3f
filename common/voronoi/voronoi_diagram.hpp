// The Voronoi diagram read off its dual, the Delaunay tetrahedralization: what a clipper asks of it, in flat
// arrays.
//
//   tetrahedron -> Voronoi vertex   facet of a tetrahedron -> Voronoi edge   edge -> Voronoi facet   site ->
//   cell
//
// Nothing is constructed here: facets, edges and vertices stay symbolic (tuples of sites); the planes are
// doubles with an error bound and serve only as filter in front of the exact side predicates.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/base/matrix3.hpp"
#include "common/base/vec.hpp"
#include "common/delaunay/tetrahedralization.hpp"

namespace fracture {

/// Bisector of site i and `neighbor` j, seen from i: value(q) = half - u·(q - p_i) is positive on i's side;
/// |value - computed| <= error for every q in the box the diagram was made for.
struct Bisector {
  Vec3d u;      ///< p_j - p_i
  double half;  ///< |u|^2 / 2
  double error;
  SiteId neighbor;
};

class VoronoiDiagram {
 public:
  /// `box` must contain every point that is ever asked about (the solid's box). With a map the diagram is
  /// that of the solid's image: sites, box and every point asked about are images.
  VoronoiDiagram(const Tetrahedralization& tetrahedralization, const Box& box,
                 const std::optional<Matrix3>& map = std::nullopt);

  const std::optional<Matrix3>& map() const { return map_; }
  /// Direction of the normal of facet (i, j), from i to j, in the frame of the solid; not of unit length.
  Vec3d facet_normal(SiteId i, SiteId j) const {
    const Vec3d u = site(j) - site(i);
    return map_ ? map_->transposed_times(u) : u;
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
  /// The site whose cell holds q, by a greedy walk from `start`: exact. About one step when `start` is near.
  SiteId nearest(const Vec3d& q, SiteId start) const;

  struct Facet {
    TetId tet;
    int face;  ///< opposite vertex `face` of `tet`
  };
  /// The Delaunay facet (i, j, k). Throws InternalError when there is none.
  Facet find_facet(SiteId i, SiteId j, SiteId k) const;

 private:
  const Tetrahedralization* dual_;
  std::optional<Matrix3> map_;
  std::vector<std::uint32_t> bisector_begin_, tet_begin_;
  std::vector<Bisector> bisectors_;
  std::vector<TetId> tets_;
};

}  // namespace fracture
