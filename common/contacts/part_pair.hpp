// The contact of two parts.
#pragma once

#include <optional>

#include "common/contacts/contact_pieces.hpp"
#include "common/contacts/contacts.hpp"
#include "common/contacts/near_triangles.hpp"

namespace fracture::contacts_detail {

/// Returns the rounding error of distances in the box, m: the length of a vector of one float step on each axis, at the axis's
/// largest coordinate. Both ends of a distance are off by at most half a step on each axis.
double rounding_of(const Box& box);

/// Smaller shares are noise from sums that cancel.
inline constexpr double kCancelled = 1e-9;

/// Measures contacts. Reuses its memory from pair to pair; one object per thread. Borrows all.
class PairMeasurer {
 public:
  PairMeasurer(const PartSurfaces& surfaces, double gap, const Execution& execution)
      : surfaces_(surfaces),
        gap_(gap),
        execution_(execution),
        pacer_(execution),
        piece_maker_(surfaces, pacer_) {}

  /// Measures the contact of parts a < b and adds its pieces. Returns nothing if the parts are farther
  /// apart than the gap. Throws Interrupted.
  std::optional<Contact> measure(std::uint32_t a, std::uint32_t b, std::vector<ContactPiece>& pieces);

 private:
  bool is_in_hollow(std::uint32_t inner, std::uint32_t outer);
  bool overlap_shows(const Box& common) const;
  bool parted_by_plane() const;
  void measure_facing(double low);
  bool within_reach();
  void sort_pieces(std::size_t first, std::vector<ContactPiece>& pieces);

  const PartSurfaces& surfaces_;
  const double gap_;
  const Execution& execution_;
  Pacer pacer_;
  NearPair pair_;
  double reach_ = 0;  ///< m: the gap and the rounding
  FacingPolygons facing_a_, facing_b_;
  PieceMaker piece_maker_;
};

}  // namespace fracture::contacts_detail
