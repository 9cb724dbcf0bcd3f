// Nothing is lost: whatever a bake writes lies where nothing else is that somebody may want.
#pragma once

#include "server/bake/line_faults.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// A fault for each output that would be written over an input, the manifest, the rules or another output, or that lies where no file
/// can be; then kBadParameter for the first of the report, pages and whatever else a bake writes once.
Expected<void> check_places(const BakePlan& plan, const BakeSource& source, LineFaults& faults);

}  // namespace fracture::bake
