#include "common/exchange/problem_document.hpp"

#include <nlohmann/json.hpp>

namespace fracture::protocol {

std::string ProblemDocument::slug() const { return type.substr(type.rfind('/') + 1); }

ProblemDocument problem_in(const nlohmann::json& document) {
  const auto text = [&](const char* key) {
    const auto it = document.is_object() ? document.find(key) : document.end();
    return it != document.end() && it->is_string() ? it->get<std::string>() : std::string();
  };
  return {
      .type = text("type"), .title = text("title"), .detail = text("detail"), .parameter = text("parameter")};
}

ProblemDocument problem_in(const Exchange& exchange) {
  ProblemDocument problem = problem_in(nlohmann::json::parse(exchange.body, nullptr, false));
  if (problem.detail.empty()) problem.detail = "The server answered " + std::to_string(exchange.status) + ".";
  return problem;
}

}  // namespace fracture::protocol
