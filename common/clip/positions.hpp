// Where the symbolic vertices are: twice over. `point` is the exact rational position rounded to double, for
// figures (volumes, areas, moments); `steps` is the same rational position rounded once, to nearest-even, on
// the seam lattice, and is what the file holds. Vertices that are equal as rationals get equal steps,
// whatever their keys.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"

namespace fracture {

/// The lattice of constructed vertices: on each axis a step of h = 2^(ceil(log2(max(R, S))) - 23), R the
/// largest |coordinate| and S the extent of the input on that axis. Coordinates are then integers of at most
/// 24 bits, so positions, pivots (multiples of h) and their differences are all exact in float32 (invariant
/// I2).
struct SeamLattice {
  std::array<int, 3> exponent{};  ///< h_a = 2^exponent[a], metres
  explicit SeamLattice(const Box& box);
  SeamLattice() = default;
  Vec3d step() const;
  Vec3d to_world(const std::array<std::int32_t, 3>& steps) const;
};

struct VertexPositions {
  SeamLattice lattice;
  CutVertexId first_constructed{0};  ///< = number of mesh vertices
  std::vector<Vec3d> points;         ///< of vertex first_constructed + k, unrounded
  std::vector<std::array<std::int32_t, 3>>
      steps;  ///< of vertex first_constructed + k, in units of the lattice
  /// Of rough cuts (rough/roughen.hpp): the first of `steps` as they were before anything moved; else empty.
  std::vector<std::array<std::int32_t, 3>> flat_steps{};
  bool are_rough() const { return !flat_steps.empty(); }
};

/// `image` is what cuts and winding were decided on: the solid itself, or, when the diagram has a map, its
/// image under it. Then cuts are carried back by their parameters along the edge or in the triangle, and
/// Voronoi vertices by the inverse map (image_constructions.hpp).
VertexPositions place_vertices(const Solid& solid, const Solid& image, const VoronoiDiagram& diagram,
                               const SurfaceCuts& cuts, const Winding& winding, const Execution& execution);

}  // namespace fracture
