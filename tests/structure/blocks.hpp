// Sets of unit cubes with positions but without shapes; tests add the bonds by hand.
#pragma once

#include <cstdint>

#include "common/fragment/fragments.hpp"

namespace fracture::test {

inline Fragment block(std::uint64_t id, const Vec3d& center) {
  Fragment f;
  f.id = id;
  f.mass.volume = 1;
  f.mass.center_of_mass = center;
  return f;
}

inline void bind(FragmentSet& set, std::uint32_t a, std::uint32_t b, double area = 1) {
  const Vec3d ca = set.fragments[a].mass.center_of_mass, cb = set.fragments[b].mass.center_of_mass;
  set.bonds.push_back({a, b, area, 0.5 * (ca + cb), (1 / length(cb - ca)) * (cb - ca)});
}

}  // namespace fracture::test
