// Makes sure that a bake overwrites no file that may still be needed.
#pragma once

#include "server/bake/line_faults.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// Adds a fault for each output that would overwrite an input, the manifest, the rules or another output, or
/// whose path cannot be a file. Returns kBadParameter for the first such problem with the report, the page or
/// any other file that a bake writes once.
Expected<void> check_places(const BakePlan& plan, const BakeSource& source, LineFaults& faults);

}  // namespace fracture::bake
