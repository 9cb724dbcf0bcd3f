// Stored data of rough cuts, with which a part of them can be made again as if all were (roughen_part() in
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

/// A cap after its movement. The vertices on the outer surface, which stay, come first.
struct KeptCut {
  SiteId lo, hi;             ///< lo < hi
  Box box;                   ///< contains all possible positions of its vertices
  std::vector<Vec3d> fixed;  ///< m
  std::vector<std::array<std::int32_t, 3>>
      flat;                  ///< for the other vertices: original positions, in steps of the seam lattice
  std::vector<Vec3d> moves;  ///< for the same vertices: their full movement, m
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
std::size_t memory_size(const KeptCut& cut);

/// The vertices at one place were moved less in one round, because two triangles crossed, or because one left
/// the surface or turned over.
struct Calming {
  std::array<std::int32_t, 3> place;  ///< original position, in steps of the seam lattice
  std::uint32_t round;
  std::array<SiteId, 4> cells;  ///< lo and hi of the facets of both triangles; of one triangle: twice

  auto operator<=>(const Calming&) const = default;
};

struct RoughTrace {
  std::vector<KeptCut> cuts;
  std::vector<Calming> calmings;  ///< ascending, without duplicates
  std::uint64_t pairs = 0;        ///< number of triangle pairs whose boxes overlapped, in all rounds
  double area = 0, edges = 0;     ///< of the flat caps, m²; of the Voronoi edges that bound them, m
};

/// Number of different places that were calmed.
std::uint64_t places_of(std::span<const Calming> calmings);

}  // namespace fracture
