#include "server/bake/baker.hpp"

namespace fracture::bake {

Expected<RequestParameters> parse_parameters(const ParameterTable& table,
                                             const std::vector<RawParameter>& given) {
  Expected<RequestParameters> parsed = table.parse(given);
  if (parsed && !parsed->of.empty())
    return fail(
        ErrorCode::kNoSuchAnswer,
        "bake keeps no answers, so 'of' cannot refer to one. Instead, give the parameters that the answer contains.",
        "of");
  return parsed;
}

}  // namespace fracture::bake
