// The surface of a contact, divided into convex pieces.
#pragma once

#include <vector>

#include "common/base/pacer.hpp"
#include "common/contacts/facing.hpp"
#include "common/contacts/overlap.hpp"
#include "common/contacts/trapezoids.hpp"

namespace fracture::contacts_detail {

/// Makes contact pieces. Reuses its memory from pair to pair; borrows all.
class PieceMaker {
 public:
  PieceMaker(const PartSurfaces& surfaces, Pacer& pacer)
      : surfaces_(surfaces), pacer_(pacer), sweep_(pacer) {}

  /// Adds the pieces of a contact measured by facing, which are polygons on its measured part.
  void add_facing(const Contact& contact, const NearPair& pair, const FacingPolygons& polygons,
                  std::vector<ContactPiece>& pieces);
  /// Adds the pieces of a contact measured by common surface.
  void add_common(const NearPair& pair, const Overlap& overlap, std::vector<ContactPiece>& pieces);
  /// Adds the pieces of a contact measured by the surface inside the other part. Some triangles of the pair
  /// coincide with the other part's surface apart from rounding, so chance would decide whether they are
  /// inside. These triangles are moved off that surface, out of the other part.
  void add_inside(const Contact& contact, NearPair& pair, const Overlap& overlap,
                  std::vector<ContactPiece>& pieces);

 private:
  void add_polygon(std::span<const Vec3d> corners, double area, const Vec3d& normal, double height,
                   std::vector<ContactPiece>& pieces) const;
  /// Moves triangles off the other part's surface. Returns, per triangle, whether it was moved; empty if
  /// none coincides.
  std::vector<char> move_off(NearPair& pair, bool of_b, std::vector<Corners>& exact);
  std::array<int, 3> windings_alone(const Corners& corners, const Crossed& crossed, std::uint32_t around,
                                    Owner owner);

  const PartSurfaces& surfaces_;
  Pacer& pacer_;
  TrapezoidSweep sweep_;
  Vec3d origin_;  ///< of the pair
};

}  // namespace fracture::contacts_detail
