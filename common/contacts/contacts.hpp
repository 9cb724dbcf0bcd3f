// The contact graph of the parts of a solid: which parts overlap, touch or come within a gap, and by how much.
//
// Each pair of parts gets two measures:
//
//   facing   The surface of each part from which a ray along the outward normal meets the other part within the gap
//            (facing.hpp). Exact for flat faces, apart from rounding. It is the surface within the gap of the other
//            part, without the rims (about as wide as the gap) where the surface turns away from that part.
//   inside   The surface of each part inside the other one, by Green's theorem over the segments in which
//            triangles cross (overlap.hpp). Exact apart from rounding. Exact predicates decide which triangles
//            cross. A symbolic translation of one part breaks ties (moved_signs.hpp).
//
// Coordinates of a solid are floats, so distances below `rounding_of()` are noise. If the mean depth of an
// overlap is at most this, the parts count as touching. Parts whose distance exceeds the gap by at most this
// count as within it.
#pragma once

#include <optional>

#include "common/base/execution.hpp"
#include "common/solid/contact_graph.hpp"
#include "common/solid/solid.hpp"

namespace fracture {

/// Default and maximum of the parameter contact_gap, as fractions of the longest side of the solid's box.
/// With larger gaps, most parts would be in contact with most others, and the number of contacts would grow
/// quadratically.
inline constexpr double kContactGap = 1e-3, kMostContactGap = 0.1;

/// Finds the contacts of all pairs of parts. `gap`: m, finite, not negative. Parts may overlap, contain
/// each other and have cavities. If a part overlaps itself, areas and volumes count as often as the part
/// winds around them.
///
/// Near-linear in triangles, in pairs of parts whose boxes meet, and in pairs of triangles within the gap.
/// The bytes do not depend on the number of threads. Throws Interrupted, even if the contacts need too much
/// memory.
ContactGraph find_contacts(const Solid& solid, double gap, const Execution& execution);

/// Finds the contacts and stores them as Solid::contacts. `gap`: m, limited to kMostContactGap; if empty,
/// kContactGap is used.
void keep_contacts(Solid& solid, std::optional<double> gap, const Execution& execution);

}  // namespace fracture
