// The last stage: pieces are assembled, those without volume united with a neighbour, and the whole is
// certified.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"
#include "common/fragment/pieces.hpp"
#include "common/fragment/size_limits.hpp"

namespace fracture {

/// Fills everything of FragmentSet but sites_asked and report. A piece whose final rounded volume is not
/// positive is united with the neighbour of largest shared cap area (ties: the lowest piece), their common
/// caps disappearing on both sides, until none is left; a piece without any neighbour is dropped and counted,
/// its volume in `pocket_volume`. Before that, pieces are united as the limits ask (unite.hpp).
FragmentSet make_fragments(const RestrictedDiagram& diagram, const Ownership& ownership, Pivot pivot,
                           const SizeLimits& limits, const Execution& execution);

}  // namespace fracture
