// Cross-origin requests of web pages (the Fetch standard's CORS protocol), off by default.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/http/api.hpp"

namespace fracture::http {

class CorsPolicy {
 public:
  CorsPolicy() = default;
  /// Origins as browsers send them, or "*" for every page.
  explicit CorsPolicy(std::vector<std::string> origins) : origins_(std::move(origins)) {}

  /// The answer to a preflight (OPTIONS with Origin and Access-Control-Request-Method): 204, with permission
  /// only for an allowed origin. Nothing for every other request, and when no origin is configured.
  std::optional<Response> preflight(const RequestHead& head) const;

  /// The fields that let the page of this request's Origin read the answer, whatever its status.
  std::vector<std::pair<std::string, std::string>> fields(const RequestHead& head) const;

  /// Is this page's origin one of those that may ask?
  bool allows(const std::string& origin) const;

 private:
  bool any() const;
  std::vector<std::string> origins_;
};

}  // namespace fracture::http
