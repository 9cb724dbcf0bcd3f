// Reads jobs from a manifest: NDJSON with {"input": ..., "output": ..., "parameters": {...}} on each line.
#pragma once

#include <vector>

#include "server/bake/line_faults.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// Returns the jobs of all readable lines and adds a fault for every other line. Returns kBadParameter if the
/// file itself cannot be read.
Expected<std::vector<BakeJob>> read_manifest(const BakeSource& source, LineFaults& faults);

/// Adds a fault for each manifest line whose parameters are invalid, on their own or combined with any of the
/// rules. The meshes are not read.
void check_parameters(const std::vector<BakeJob>& jobs, const RuleFile& rules, const ParseParameters& parse,
                      LineFaults& faults);

/// Adds a fault for each manifest line whose input is missing, a folder, or not permitted to be read.
void check_inputs(const std::vector<BakeJob>& jobs, LineFaults& faults);

}  // namespace fracture::bake
