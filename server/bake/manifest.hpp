// The jobs of a manifest: NDJSON, {"input": ..., "output": ..., "parameters": {...}} on each line.
#pragma once

#include <vector>

#include "server/bake/line_faults.hpp"
#include "server/bake/plan.hpp"

namespace fracture::bake {

/// Those of the lines that can be read; every other line is a fault. kBadParameter: the file itself cannot be read.
Expected<std::vector<BakeJob>> read_manifest(const BakeSource& source, LineFaults& faults);

/// A fault for each job of a line whose parameters are wrong, whatever its mesh: without a rule, and with each of the rules.
void check_parameters(const std::vector<BakeJob>& jobs, const RuleFile& rules, const ParseParameters& parse,
                      LineFaults& faults);

}  // namespace fracture::bake
