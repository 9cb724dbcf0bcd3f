// Cross-origin requests from web pages (the CORS protocol of the Fetch standard). Off by default.
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
  /// `origins`: origins as browsers send them, or "*" for all pages.
  explicit CorsPolicy(std::vector<std::string> origins) : origins_(std::move(origins)) {}

  /// Answers a preflight (OPTIONS with Origin and Access-Control-Request-Method) with 204; only an allowed
  /// origin gets permission. Returns nothing for other requests and if no origin is configured.
  std::optional<Response> preflight(const RequestHead& head) const;

  /// Returns the fields that let the page with this request's Origin read the answer, whatever its status.
  std::vector<std::pair<std::string, std::string>> fields(const RequestHead& head) const;

  /// Returns whether pages of this origin may send requests.
  bool allows(const std::string& origin) const;

 private:
  bool any() const;
  std::vector<std::string> origins_;
};

}  // namespace fracture::http
