// Rough cuts: the caps between fragments are refined (refine.hpp), and their vertices are moved by noise
// (noise.hpp). The noise depends only on position, so both sides of a cut still match bit for bit, and the
// pieces still partition the solid. The movement fades to zero at the outer surface, which does not change.
//
// Why nothing crosses: p -> p + d(p) is one to one if |d(p) - d(q)| < |p - q|, and moves no point out of the
// solid if |d(p)| is less than the distance to its surface. The second condition always holds. The first
// holds for the permitted amplitudes, except for rare peaks of the noise, and triangles only sample d. So the
// result is tested (crossings.hpp). If caps cross one another or the outer surface, or a triangle turns
// over in its cap, the vertices there are moved less, or not at all.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/rough/crossings.hpp"
#include "common/rough/displacement.hpp"
#include "common/rough/restraint.hpp"
#include "common/rough/roughness.hpp"

namespace fracture {

struct RoughReport {
  double amplitude = 0;         ///< the amplitude used, m: at most the requested one
  double asked = 0;             ///< the requested amplitude, m
  double length = 0;            ///< edge length of the refined caps, m
  std::uint64_t triangles = 0;  ///< in all rough caps
  std::uint64_t calmed = 0;     ///< places that are moved less because triangles crossed or turned over
  /// Pairs of triangles that still cross: 0 unless the surface crosses itself.
  std::uint64_t crossing = 0;
  /// The cuts are flat, because too many pairs of triangles have overlapping boxes to test them all.
  bool given_up = false;
};

/// Maximum of amplitude times frequency of the coarsest octave. Larger amplitudes are reduced.
inline constexpr double kMostSteepness = 0.5;
/// Edges of the refined caps per wave of the finest octave.
inline constexpr double kEdgesPerWave = 2;
/// Approximate limit for the triangles of refined caps and for the ends of the edges between them, in addition
/// to those of flat caps. Edges are made longer until both limits are met.
inline constexpr double kMostRoughTriangles = 400'000;

/// Replaces the triangles of the caps between different owners (`owner_of_site`: cells of one owner stay
/// together), and moves the vertices inside the solid. Vertices on its surface stay. Fills Caps::normals and
/// VertexPositions::flat_steps. Does nothing if the amplitude is 0. If the diagram has a map, the waves are
/// stretched like the cells. Caps of restrained cells are moved less, or are unchanged. The other caps are
/// the same as without restraints, except for vertices shared with restrained caps.
RoughReport roughen(RestrictedDiagram& diagram, const std::vector<std::uint32_t>& owner_of_site,
                    const Roughness& roughness, const Restraints& restraints, std::uint64_t seed,
                    const Execution& execution);

/// Maximum movement of cuts, for each frame of the map (one entry if there is no map).
std::vector<Movement> movements_of_cuts(const Solid& solid, const Roughness& roughness, const CellMap& map);

}  // namespace fracture
