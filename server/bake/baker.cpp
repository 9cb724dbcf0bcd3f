#include "server/bake/baker.hpp"

namespace fracture::bake {

Expected<RequestParameters> parse_parameters(const ParameterTable& table,
                                             const std::vector<RawParameter>& given) {
  Expected<RequestParameters> parsed = table.parse(given);
  if (parsed && !parsed->of.empty())
    return fail(ErrorCode::kNoSuchAnswer,
                "A bake makes each file from its own parameters: 'of' names an answer that no baker keeps.",
                "of");
  return parsed;
}

}  // namespace fracture::bake
