#include "common/base/figures.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace fracture {

Figures::Figures(nlohmann::json object)
    : object_(std::make_shared<const nlohmann::json>(std::move(object))) {}

const nlohmann::json& Figures::operator*() const {
  static const nlohmann::json kNone = nlohmann::json::object();
  return object_ ? *object_ : kNone;
}

}  // namespace fracture
