// What is kept of rough cuts, so that a part of them can be made anew as if all were (roughen_part() in
// roughen.hpp).
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/vec.hpp"
#include "common/clip/restricted_diagram.hpp"

namespace fracture {

/// A cap as it is moved. Vertices: first those on the outer surface, which stay, then the others.
struct KeptCut {
  SiteId lo, hi;             ///< lo < hi
  Box box;                   ///< around all places that its vertices may take
  std::vector<Vec3d> fixed;  ///< m
  std::vector<std::array<std::int32_t, 3>>
      flat;                  ///< of the others: before they move, steps of the seam lattice
  std::vector<Vec3d> moves;  ///< of these, m: all of their movement
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
std::size_t memory_size(const KeptCut& cut);

/// What lies at one place was moved less in one round, because two triangles crossed, or one did not lie as it
/// should.
struct Calming {
  std::array<std::int32_t, 3> place;  ///< before it moved, steps of the seam lattice
  std::uint32_t round;
  std::array<SiteId, 4> cells;  ///< lo and hi of the facets of both triangles; of one twice

  auto operator<=>(const Calming&) const = default;
};

struct RoughTrace {
  std::vector<KeptCut> cuts;
  std::vector<Calming> calmings;  ///< ascending, none twice
  std::uint64_t pairs = 0;        ///< of triangles whose boxes met, in all rounds
  double area = 0, edges = 0;     ///< m², m: of the flat caps, and of the Voronoi edges that bound them
};

/// Different places that were calmed.
std::uint64_t places_of(std::span<const Calming> calmings);

}  // namespace fracture
