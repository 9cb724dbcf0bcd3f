// The surface of each of two parts that is inside the other, and their common volume.
#pragma once

#include <optional>

#include "common/base/pacer.hpp"
#include "common/contacts/crossings.hpp"
#include "common/contacts/near_triangles.hpp"

namespace fracture::contacts_detail {

/// The surface of one part that is inside the other one.
struct Inside {
  Patch patch;
  Vec3d outward;  ///< the integral of the normal, m²
  void take(const Patch& less, const Vec3d& normal) {
    patch.add(-less.area, -1 * less.moment);
    outward = outward - less.area * normal;
  }
};

struct Overlap {
  Inside a{}, b{};      ///< without the surface that coincides with the other part's
  Patch flush{};        ///< common surface that faces the same way in both parts
  double volume = 0;    ///< m³
  double depth = 0;     ///< m: mean depth, the volume divided by the larger inside area, with common surface
  Crossings crossings;  ///< of the pair
  std::vector<std::array<int, 3>> windings_a{},
      windings_b{};                                         ///< per triangle of the pair: corner_windings()
  std::vector<std::array<std::uint32_t, 2>> flush_pairs{};  ///< triangles that coincide in `flush`
};

/// Completes the pair and measures its overlap. Returns nothing if no triangles cross and neither part is
/// inside the other. Touching parts may have an overlap without volume, because of the translation in
/// moved_signs.hpp.
///
/// The surface of the common volume consists of the surface of each part inside the other one. So this
/// volume is a third of the integral of position · normal over both (the divergence theorem). In a
/// triangle's plane, the region inside the other part is bounded by pieces of the triangle's edges and by
/// the segments along which the other part crosses it. By Green's theorem, area and first moment are sums
/// over these in any order, without building polygons. The translation decides whether coincident surfaces
/// are inside or outside. If they are inside, their area is subtracted.
std::optional<Overlap> find_overlap(const PartSurfaces& surfaces, NearPair& pair, const Execution& execution,
                                    Pacer& pacer);

}  // namespace fracture::contacts_detail
