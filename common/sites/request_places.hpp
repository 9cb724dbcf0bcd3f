// Compares the places in a request with the solid: puts impacts on it, and finds points that have no effect.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/execution.hpp"
#include "common/base/remarks.hpp"
#include "common/sites/pattern.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// The impacts of a pattern; none if the pattern has no impacts.
std::span<const Vec3d> impacts_of(const SitePattern& pattern);

/// An impact outside the solid and farther from its surface than this share of the solid's longest side is
/// moved.
inline constexpr double kFarFromSolid = 0.1;

/// Moves each impact that is far outside the solid to the nearest point of its surface, with a warning. Gives
/// an ImpactPattern without impacts a default impact: the centre of the solid's box if that is in the solid,
/// otherwise the point of its surface nearest to that centre, with a note. Leaves other patterns as they are.
/// Linear in triangles for each impact. Throws Interrupted.
void put_impacts_on(const Solid& solid, SitePattern& pattern, Remarks& remarks, const Execution& execution);

/// Warns if no point of a PointsPattern is in the solid, if points are far outside its box, and if points are
/// equal. Near-linear in triangles + points. Throws Interrupted.
void check_points(const Solid& solid, const std::vector<Vec3d>& points, Remarks& remarks,
                  const Execution& execution);

/// A place of the request outside the solid, in the words of a warning.
struct FarPlace {
  std::string place;       ///< as in the request: "50,50,50"
  double distance = 0;     ///< m, from the surface
  std::string correction;  ///< "Move 'local_point' onto the mesh; …", or the unit that it is probably in
};
/// Returns nothing if the place is in the solid, or at most `near` metres from its surface. `parameter` has the place. Linear in
/// triangles. Throws Interrupted.
std::optional<FarPlace> far_place(const Solid& solid, const Vec3d& place, double near, const char* parameter,
                                  const Execution& execution);

/// Returns "centimetres", "millimetres" or "inches": the unit in which `place` would be in or near the box. Returns nothing if no
/// unit would help. `place` is far from the box in metres.
std::optional<std::string> likely_unit(const Vec3d& place, const Box& box);

}  // namespace fracture
