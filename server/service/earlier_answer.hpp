// Requests that name an earlier answer (`of`): they use that answer's parameters, combined with those given now.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/error.hpp"
#include "common/parameters/parameters.hpp"
#include "server/service/result.hpp"

namespace fracture {

/// Returns the parameters to parse instead of `given`, which parses to `own`. `earlier`: canonical parameters of the earlier
/// answer. New hits are appended to its own hits. Parameters that determine its mesh or its sites must not be given again.
/// If new hits are compared with the answer (`delta`), no other parameters that its fragments depend on may be given.
/// Errors: kBadParameter, with the name of the parameter.
Expected<std::vector<RawParameter>> on_earlier_answer(const ParameterTable& table,
                                                      const std::vector<RawParameter>& given,
                                                      const RequestParameters& own,
                                                      const nlohmann::json& earlier);

}  // namespace fracture
