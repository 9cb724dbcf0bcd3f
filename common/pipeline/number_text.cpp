#include "common/pipeline/number_text.hpp"

#include <nlohmann/json.hpp>

namespace fracture {

std::string text_of(double value) { return nlohmann::json(value).dump(); }

}  // namespace fracture
