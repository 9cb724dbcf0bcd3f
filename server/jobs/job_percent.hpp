// Computes the progress of a job in percent from its stage and the progress of that stage.
#pragma once

#include <cstdint>

#include "common/base/stage.hpp"

namespace fracture {

/// Returns the percent at which clip begins in a job with `passes` relaxation passes (`lloyd`). Each pass
/// tetrahedralizes and clips once more, without the stages that follow.
int clip_begins(std::uint32_t passes);

/// `fraction`: the part of the stage that is done, in [0, 1].
int percent_of(Stage stage, double fraction, int clip_begins);

}  // namespace fracture
