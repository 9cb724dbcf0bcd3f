// How far a job is as one number, from the stage that it is in and how far that is.
#pragma once

#include <cstdint>

#include "common/base/stage.hpp"

namespace fracture {

/// The percent at which clip begins in a job with so many passes of relaxation (`lloyd`): each
/// tetrahedralizes and clips once more, with less behind it.
int clip_begins(std::uint32_t passes);

/// `fraction` of that stage done, in [0, 1].
int percent_of(Stage stage, double fraction, int clip_begins);

}  // namespace fracture
