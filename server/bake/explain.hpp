// Why a job has the parameters that it has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/bake/plan.hpp"

namespace fracture::bake {

/// The parameters of the command line, over them those of the rule that matches, over them those of the manifest's line.
struct JobParameters {
  std::vector<RawParameter> all;
  std::optional<RuleMatch> match;  ///< nothing: no rule does
};
JobParameters parameters_of(const BakeJob& job, const RuleFile& rules, std::optional<RuleMatch> match);

/// What the command line or the manifest's line says that the mesh is: its names have to be read before a rule's parameters
/// are known, so that a rule's `format` has no say in it.
std::optional<MeshFormat> format_given(const BakeJob& job);

/// Lines for people, without control characters of names: input and output, the rule that matches and why, each parameter with where it comes from.
std::string explanation_of(const BakeJob& job, const RuleFile& rules, const JobParameters& parameters);

}  // namespace fracture::bake
