// Rough cuts: the caps between fragments are refined (refine.hpp) and their vertices moved by noise
// (noise.hpp), a function of position alone, so that both sides of a cut still match bit for bit and the
// pieces still partition the solid. The movement fades to nothing at the outer surface, which stays as it
// was.
//
// Why nothing crosses: p -> p + d(p) is one to one where |d(p) - d(q)| < |p - q|, and it takes no point out
// of the solid where |d(p)| is less than the distance to its surface. The second always holds; the first
// holds for the amplitudes that are allowed but for rare peaks of the noise, and triangles only sample d. So
// the result is looked at (crossings.hpp): where caps cross one another or the outer surface, or a triangle
// turns over in its cap, the vertices there are moved less, down to not at all.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/base/execution.hpp"
#include "common/clip/restricted_diagram.hpp"
#include "common/rough/crossings.hpp"
#include "common/rough/displacement.hpp"
#include "common/rough/restraint.hpp"
#include "common/rough/roughness.hpp"
#include "common/rough/trace.hpp"

namespace fracture {

struct RoughReport {
  double amplitude = 0;         ///< m, in force: at most what was asked
  double asked = 0;             ///< m
  double length = 0;            ///< m, of the edges the caps were refined to
  std::uint64_t triangles = 0;  ///< of all rough caps
  std::uint64_t calmed = 0;     ///< places that are moved less, because triangles crossed or turned over
  /// Pairs of triangles that cross all the same: 0 unless the surface crosses itself.
  std::uint64_t crossing = 0;
  /// The cuts are flat all the same: more pairs of triangles lie in each other's boxes than can be looked at.
  bool given_up = false;
};

/// Larger amplitudes are lowered: amplitude times frequency of the coarsest octave.
inline constexpr double kMostSteepness = 0.5;
/// Edges of the refined caps per wave of the finest octave.
inline constexpr double kEdgesPerWave = 2;
/// Edges are made longer until the caps have at most about so many triangles, and the edges between them so
/// many ends, beyond those of flat caps.
inline constexpr double kMostRoughTriangles = 400'000;

/// Replaces the triangles of the caps between different owners (`owner_of_site`: cells of one owner stay
/// together) and moves the vertices inside the solid; those on its surface stay. Fills Caps::normals and
/// VertexPositions::flat_steps. With an amplitude of 0 nothing changes. Where the diagram has a map the waves
/// are stretched as the cells are. Caps of restrained cells are moved less, or stay as they are; the others
/// stay what they would be without restraints, but for vertices that they share.
/// `trace`, if not null, gets what roughen_part() needs; nothing where a part cannot be made without the rest:
/// triangles are longer than asked because there are many, cells are restrained, or something crosses.
RoughReport roughen(RestrictedDiagram& diagram, const std::vector<std::uint32_t>& owner_of_site,
                    const Roughness& roughness, const Restraints& restraints, std::uint64_t seed,
                    const Execution& execution, std::optional<RoughTrace>* trace = nullptr);

/// How far cuts move at most, for each frame of the map (one without a map).
std::vector<Movement> movements_of_cuts(const Solid& solid, const Roughness& roughness, const CellMap& map);

/// The whole of which a diagram is a part.
struct RoughWhole {
  const Solid& solid;
  std::span<const SiteId> sites;  ///< per site of the part its number in the whole; ascending
  std::span<const SiteId>
      made;            ///< of the whole, ascending: the cells that have all of their caps in the part
  double area, edges;  ///< as in RoughTrace: no less than those of the caps that stay
  std::span<const Calming> calmings;  ///< of the whole as it was
  /// The cuts of the whole as it was, between cells that are not made, whose boxes meet one of these, or a place that
  /// was calmed because of a cell that is made.
  std::function<std::vector<const KeptCut*>(std::vector<Box>)> near;
};
struct RoughPart {
  RoughReport report;  ///< asked, amplitude and length
  RoughTrace trace;    ///< of the caps of the made cells; area and edges with those of the whole
  /// Cells whose caps, if all were made, would not be what they were: these have to be made, too.
  std::vector<SiteId> spread;
};
/// The caps of the made cells as roughen() makes them among all, to the bit. Nothing where that cannot be. Throws
/// Interrupted.
std::optional<RoughPart> roughen_part(RestrictedDiagram& diagram,
                                      const std::vector<std::uint32_t>& owner_of_site,
                                      const Roughness& roughness, std::uint64_t seed, const RoughWhole& whole,
                                      const Execution& execution);

}  // namespace fracture
