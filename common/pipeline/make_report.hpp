#pragma once

#include <cstdint>

#include "common/pipeline/fracture_steps.hpp"

namespace fracture {

/// The report but for what the pipeline does not know (Report::frame, passed_through). `cut`: its figures, its set may be gone.
/// `anchored`: how many fragments are. `hulls`: of the fragments of the set. Throws Interrupted.
Report make_report(const Solid& solid, const SiteNotes& sites, const FractureParameters& parameters,
                   const CutCells& cut, std::uint32_t anchored, const HullReport& hulls,
                   const FragmentSet& set, const Execution& execution);

}  // namespace fracture
