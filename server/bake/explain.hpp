// Explains where a job's parameters come from.
#pragma once

#include <optional>
#include <string>

#include "server/bake/plan.hpp"
#include "server/bake/rule_parameters.hpp"

namespace fracture::bake {

/// Returns the mesh format that the command line or the manifest line gives. A rule's `format` is not
/// considered, because rules can only be matched after the names in the mesh have been read.
std::optional<MeshFormat> format_given(const BakeJob& job);

/// Returns lines for the console: input and output, the matching rules and why they match, and each parameter
/// with its origin. Control characters in names are escaped.
std::string explanation_of(const BakeJob& job, const RuleFile& rules, const JobParameters& parameters);

}  // namespace fracture::bake
