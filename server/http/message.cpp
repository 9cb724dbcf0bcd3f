#include "server/http/message.hpp"

#include "common/base/json_text.hpp"

namespace fracture::http {

std::string_view Response::header(std::string_view name) const {
  for (const auto& field : headers)
    if (field.first == name) return field.second;
  return {};
}

Response Response::text(int status, std::string content_type, std::string body) {
  Response response;
  response.status = status;
  response.content_type = std::move(content_type);
  const auto text = std::make_shared<const std::string>(std::move(body));
  response.body = {reinterpret_cast<const std::uint8_t*>(text->data()), text->size()};
  response.owner = text;
  return response;
}

Response Response::json(const nlohmann::ordered_json& document, int status) {
  return text(status, "application/json", json_text(document, 2) + "\n");
}

Response Response::problem(const Problem& problem, std::string_view request_id) {
  Response response = text(problem.type->status, "application/problem+json", problem.body(request_id));
  response.headers = problem.headers;
  return response;
}

}  // namespace fracture::http
