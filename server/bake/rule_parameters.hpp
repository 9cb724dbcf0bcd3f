// Combines the command line, the rules and a manifest line to the parameters of one mesh.
#pragma once

#include <vector>

#include "server/bake/plan.hpp"

namespace fracture::bake {

/// A job's parameters. The manifest line takes precedence over the rules, which take precedence over the command line.
struct JobParameters {
  std::vector<RawParameter> all;
  std::vector<RuleMatch> matches;  ///< empty if no rule matches
};

/// `matches`: of RuleTally::find(). A rule by node or material becomes an entry of `assign`: its properties of materials apply
/// to the parts that it matches. Without a `material`, they are added to those of the command line. Its other parameters apply
/// to the whole mesh; of several rules with the same one, the first decides. The entries of a manifest line come before
/// those of rules, and those of the command line after them.
JobParameters parameters_of(const BakeJob& job, const RuleFile& rules, std::vector<RuleMatch> matches);

}  // namespace fracture::bake
