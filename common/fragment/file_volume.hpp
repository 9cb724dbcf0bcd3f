// Volume of a fragment as written to the file.
#pragma once

#include "common/base/execution.hpp"
#include "common/fragment/fragments.hpp"

namespace fracture {

/// Volume enclosed by the final rounded positions (float32, local), m³, and its exact sign. `volume` has
/// that sign, too.
struct FileVolume {
  double volume = 0;
  int sign = 0;
};
/// Throws Interrupted.
FileVolume file_volume(const Fragment& fragment, const Execution& execution = kUninterrupted);

}  // namespace fracture
