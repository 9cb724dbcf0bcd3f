// Positions of the symbolic vertices, in two forms. `point` is the exact rational position rounded to double,
// for measurements (volumes, areas, moments). `steps` is the same rational position rounded once, to
// nearest-even, on the seam lattice; files contain this form. Vertices that are equal as rationals get equal
// steps, even if their keys differ.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/clip/surface_cuts.hpp"
#include "common/clip/winding.hpp"

namespace fracture {

/// The lattice of constructed vertices. The step on each axis is h = 2^(ceil(log2(max(R, S))) - 23), where R
/// is the largest |coordinate| and S the extent of the input on that axis. So coordinates are integers of at
/// most 24 bits. Therefore positions, pivots (multiples of h) and their differences are all exact in float32
/// (invariant I2).
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
  std::vector<Vec3d> points;         ///< of vertex first_constructed + k, not rounded to the lattice
  /// The place of vertex first_constructed + k, in units of the lattice
  std::vector<std::array<std::int32_t, 3>> steps;
  /// For rough cuts (rough/roughen.hpp): the original values of the first `steps`, before anything moved;
  /// otherwise empty.
  std::vector<std::array<std::int32_t, 3>> flat_steps{};
  bool are_rough() const { return !flat_steps.empty(); }
};

/// `image` is the surface on which cuts and winding were computed: the solid itself or, if the diagram has a
/// map, the solid's image under it. In an image, cuts are mapped back by their parameters along the edge or
/// in the triangle, and Voronoi vertices by the inverse map (image_constructions.hpp).
VertexPositions place_vertices(const Solid& solid, const Solid& image, const VoronoiDiagram& diagram,
                               const SurfaceCuts& cuts, const Winding& winding, const Execution& execution);

}  // namespace fracture
