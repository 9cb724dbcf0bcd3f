// What an answer says of itself beside its fragments (FracturedSolid::report): what was asked, what was made,
// and everything that somebody should know about the difference.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "common/pipeline/fracture_steps.hpp"

namespace fracture {

/// `cut`: its figures, its set may be gone. `anchored`: how many fragments are. `hulls`: of the fragments of
/// the set.
nlohmann::json make_report(const Solid& solid, const Diagram& diagram, const FractureParameters& parameters,
                           const CutCells& cut, std::uint32_t anchored, const HullReport& hulls,
                           const FracturedSolid& made);

}  // namespace fracture
