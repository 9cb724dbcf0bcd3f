// Meshes of several parts, fractured together with the contacts of their parts, and the bonds between the
// parts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "common/contacts/contacts.hpp"
#include "tests/support/fractured.hpp"
#include "tests/support/shapes.hpp"
#include "tests/support/solids.hpp"

namespace fracture::test {

inline Solid solid_in_contact(const std::vector<Mesh>& parts, std::optional<double> gap = {}) {
  Solid solid = solid_of(joined(parts));
  keep_contacts(solid, gap, {});
  return solid;
}

/// Parameters that cut by the Voronoi diagram of the points, each part on its own.
inline FractureParameters cut_by(std::vector<Vec3d> points) {
  FractureParameters p;
  p.parts = Parts::kApart;
  p.pattern = PointsPattern{std::move(points)};
  return p;
}

inline bool is_across(const FragmentSet& set, const Bond& bond) {
  return set.fragments[bond.a].part != set.fragments[bond.b].part;
}
inline std::vector<Bond> bonds_across(const FragmentSet& set) {
  std::vector<Bond> across;
  for (const Bond& bond : set.bonds)
    if (is_across(set, bond)) across.push_back(bond);
  return across;
}

/// The fragment of a part whose centre of mass is nearest to `place`.
inline std::uint32_t fragment_at(const FragmentSet& set, std::uint32_t part, const Vec3d& place) {
  std::uint32_t nearest = kNoIndex;
  const auto off = [&](std::uint32_t k) { return length(set.fragments[k].mass.center_of_mass - place); };
  for (std::uint32_t k = 0; k < set.fragments.size(); ++k)
    if (set.fragments[k].part == part && (nearest == kNoIndex || off(k) < off(nearest))) nearest = k;
  return nearest;
}

/// The bond between two fragments; its normal points from `a` to `b`.
inline std::optional<Bond> bond_of(const FragmentSet& set, std::uint32_t a, std::uint32_t b) {
  for (Bond bond : set.bonds)
    if (bond.a == std::min(a, b) && bond.b == std::max(a, b)) {
      if (a > b) bond.normal = -1.0 * bond.normal;
      return bond;
    }
  return std::nullopt;
}

}  // namespace fracture::test
