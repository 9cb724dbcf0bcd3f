#pragma once

#include <cstdint>
#include <optional>

#include "common/pipeline/fracture_steps.hpp"

namespace fracture {

/// Makes the report, except for members that the pipeline does not know (Report::frame, passed_through). The set of
/// `cut` may already have been moved out. `anchored`: number of anchored fragments; empty if not requested, or if the set is only part of the answer.
/// `hulls`: of the set's fragments. `rest`: of all fragments. Throws Interrupted.
Report make_report(const Solid& solid, const SiteNotes& sites, const FractureParameters& parameters,
                   const CutCells& cut, std::optional<std::uint32_t> anchored, const HullReport& hulls,
                   const std::optional<Rest>& rest, const FragmentSet& set, const Execution& execution);

/// The warning if no fragment touches an anchor.
inline constexpr const char* kNothingAnchored =
    "No fragment touches an anchor, so nothing is held. Move the anchors onto the mesh; their coordinates are in "
    "metres, with y up.";

}  // namespace fracture
