// Finds parameters that had no effect in an answer, and says why. One table has a check for each parameter
// that can be without effect; it sees the request and the finished answer. (Parameters that a stage does not
// use for reasons that only this stage knows, such as a kept region outside the mesh, are reported there.)
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/parameters/parameters.hpp"
#include "common/pipeline/fractured_solid.hpp"

namespace fracture {

/// Returns one sentence, with the parameter's name, for each parameter whose value had no effect. Only
/// parameters whose values differ from those that the material and the pattern set alone: a default needs no
/// effect. Depends only on canonical_parameters() and the answer.
std::vector<std::string> parameters_without_effect(const RequestParameters& parameters,
                                                   const FracturedSolid& answer);

/// Whether the table has a check for this parameter.
bool has_effect_check(std::string_view parameter);

/// The request with the same material and pattern and no other parameters.
RequestParameters baseline_of(const RequestParameters& parameters);

}  // namespace fracture
