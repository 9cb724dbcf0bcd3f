#include "common/contacts/overlap.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/contacts/crossings.hpp"
#include "common/contacts/facing.hpp"
#include "common/contacts/vertex_windings.hpp"

namespace fracture::contacts_detail {
namespace {

/// Minimum cosine between normals of coplanar triangles.
constexpr double kParallel = 1 - 1e-9;

/// Subtracts the surface that coincides with the other part's surface.
void take_common_surface(const NearPair& pair, Overlap& overlap, Pacer& pacer) {
  const Crossings& crossings = overlap.crossings;
  const std::vector<Corners>&a = crossings.corners(Owner::kA), &b = crossings.corners(Owner::kB);
  for (const auto& [i, k] : pair.pairs) {
    pacer.step();
    const NearTriangle &s = pair.a[i], &t = pair.b[k];
    const double cosine = dot(s.normal, t.normal);
    if (!(std::fabs(cosine) > kParallel) ||
        std::fabs(dot(s.normal, t.corners[0] - s.corners[0])) > pair.rounding ||
        !crossings.signs().coplanar(a[i], b[k]))
      continue;
    const Patch common = part_over(s, t, {-pair.rounding, pair.rounding}, cosine > 0);
    const bool outwards = MovedSigns::moves_outwards(a[i]);
    if (cosine > 0) {
      overlap.flush.add(common.area, common.moment);
      overlap.flush_pairs.push_back({i, k});
    }
    // If both triangles face the same way, the one that is moved less far outwards is inside. If they face
    // each other, both or neither are inside.
    if (cosine > 0 ? !outwards : outwards) overlap.a.take(common, s.normal);
    if (outwards) overlap.b.take(common, t.normal);
  }
}

/// Adds a third of the integral of position · normal to `volume`.
Inside inside_of_all(const PartSurfaces& surfaces, const std::vector<NearTriangle>& triangles,
                     const std::vector<Crossed>& crossed, std::uint32_t around, Owner owner, double& volume,
                     std::vector<std::array<int, 3>>& windings, Pacer& pacer) {
  std::vector<EdgeJumps> jumps;
  jumps.reserve(crossed.size());
  for (const Crossed& c : crossed) jumps.push_back(c.jumps);
  windings = corner_windings(surfaces, triangles, jumps, around, owner, pacer);
  Inside inside;
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    pacer.step();
    const NearTriangle& t = triangles[k];
    const Patch patch = inside_of(t, crossed[k], windings[k]);
    inside.patch.add(patch.area, patch.moment);
    inside.outward = inside.outward + patch.area * t.normal;
    volume += (1.0 / 3) * patch.area * dot(t.normal, t.corners[0]);
  }
  return inside;
}

/// Whether the first part is inside the other one, if their triangles do not cross.
bool is_inside(const PartSurfaces& surfaces, std::uint32_t part, std::uint32_t around, Owner owner,
               Pacer& pacer) {
  const auto& parts = surfaces.solid().parts;
  if (!contains(parts[around].box, parts[part].box)) return false;
  const Vec3d corner = surfaces.corners(surfaces.first_of(part))[0];
  return winding_around(surfaces, around, corner, owner, pacer) != 0;
}

}  // namespace

std::optional<Overlap> find_overlap(const PartSurfaces& surfaces, NearPair& pair, const Execution& execution,
                                    Pacer& pacer) {
  std::optional<Crossings> found;
  const auto cross_all = [&] {
    found.emplace(surfaces.solid(), pair, exact_corners(surfaces, pair.a), exact_corners(surfaces, pair.b),
                  pacer);
  };
  cross_all();
  if (!found->any() && !is_inside(surfaces, pair.part_a, pair.part_b, Owner::kA, pacer) &&
      !is_inside(surfaces, pair.part_b, pair.part_a, Owner::kB, pacer))
    return std::nullopt;
  if (!pair.whole) {
    pair.gather_whole(surfaces, execution, pacer);
    cross_all();
  }
  Overlap overlap{.crossings = std::move(*found)};
  overlap.a = inside_of_all(surfaces, pair.a, overlap.crossings.of(Owner::kA), pair.part_b, Owner::kA,
                            overlap.volume, overlap.windings_a, pacer);
  overlap.b = inside_of_all(surfaces, pair.b, overlap.crossings.of(Owner::kB), pair.part_a, Owner::kB,
                            overlap.volume, overlap.windings_b, pacer);
  const double most = std::max(overlap.a.patch.area, overlap.b.patch.area);
  overlap.depth = most > 0 ? overlap.volume / most : 0;
  take_common_surface(pair, overlap, pacer);
  return overlap;
}

}  // namespace fracture::contacts_detail
