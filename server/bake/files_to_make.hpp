// The files that a bake makes. Their folders are tried before anything is computed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/bake/run.hpp"

namespace fracture::bake {

/// Returns the files that a run writes, except its report: the page, the depfile, outputs and pictures, and one file for each
/// folder of failures or stages. Files of jobs for which `known` is true are left out if they may be kept. Entries may be
/// empty.
std::vector<std::string> files_to_make(const BakePlan& plan, const RunOptions& options,
                                       const std::function<bool(const BakeJob&)>& known);

}  // namespace fracture::bake
