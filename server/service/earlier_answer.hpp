// A request that names an earlier answer (`of`): the parameters of that answer, with what is given now.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "common/base/error.hpp"
#include "common/parameters/parameters.hpp"
#include "server/service/result.hpp"

namespace fracture {

/// What to parse instead of `given`, which parses to `own`. `earlier` are the canonical parameters of the
/// answer. Hits that are given now come after its own; whatever decides its mesh or its sites cannot be given
/// again, nor beside hits that are compared with it (`delta`) anything else that its fragments depend on.
/// Errors: kBadParameter, naming the parameter.
Expected<std::vector<RawParameter>> on_earlier_answer(const ParameterTable& table,
                                                      const std::vector<RawParameter>& given,
                                                      const RequestParameters& own,
                                                      const nlohmann::json& earlier);

}  // namespace fracture
