// Explains where a job's parameters come from.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/bake/plan.hpp"

namespace fracture::bake {

/// A job's parameters. The manifest line takes precedence over the matching rule, which takes precedence over
/// the command line.
struct JobParameters {
  std::vector<RawParameter> all;
  std::optional<RuleMatch> match;  ///< empty if no rule matches
};
JobParameters parameters_of(const BakeJob& job, const RuleFile& rules, std::optional<RuleMatch> match);

/// Returns the mesh format that the command line or the manifest line gives. A rule's `format` is not
/// considered, because rules can only be matched after the names in the mesh have been read.
std::optional<MeshFormat> format_given(const BakeJob& job);

/// Returns lines for the console: input and output, the matching rule and why it matches, and each parameter
/// with its origin. Control characters in names are escaped.
std::string explanation_of(const BakeJob& job, const RuleFile& rules, const JobParameters& parameters);

}  // namespace fracture::bake
