#include "common/exchange/problem_document.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/json_reader.hpp"

namespace fracture::protocol {

std::string ProblemDocument::slug() const { return type.substr(type.rfind('/') + 1); }

ProblemDocument problem_in(const nlohmann::json& document) {
  const auto text = [&](const char* key) {
    const auto it = document.is_object() ? document.find(key) : document.end();
    return it != document.end() && it->is_string() ? it->get<std::string>() : std::string();
  };
  nlohmann::json extra = document.is_object() ? document : nlohmann::json::object();
  for (const char* known : {"type", "title", "status", "detail", "instance", "parameter", "request_id"})
    extra.erase(known);
  return {.type = text("type"),
          .title = text("title"),
          .detail = text("detail"),
          .parameter = text("parameter"),
          .extra = Figures(std::move(extra))};
}

ProblemDocument problem_in(const Exchange& exchange) {
  ProblemDocument problem = problem_in(json_or_null(exchange.body, {.depth = 16}));
  if (problem.detail.empty())
    problem.detail = "The server responded with status " + std::to_string(exchange.status) + ".";
  return problem;
}

}  // namespace fracture::protocol
