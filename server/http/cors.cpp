#include "server/http/cors.hpp"

#include <algorithm>

namespace fracture::http {
namespace {

constexpr const char* kMethods = "GET, HEAD, POST, PUT, DELETE";
constexpr const char* kRequestFields =
    "Accept, Authorization, Content-Digest, Content-Encoding, Content-Type, If-Match, If-None-Match, "
    "If-Range, Prefer, Priority, Range, Request-Timeout, Traceparent, X-Request-Id";
constexpr const char* kExposedFields =
    "Accept-Ranges, Cache-Status, Content-Location, Content-Range, ETag, Fracture-Algorithm, Link, "
    "Location, Preference-Applied, RateLimit, RateLimit-Policy, Repr-Digest, Retry-After, Server-Timing, "
    "X-Request-Id";
/// Two hours, the longest time that any browser caches the answer to a preflight.
constexpr const char* kMaxAge = "7200";

}  // namespace

bool CorsPolicy::any() const { return std::find(origins_.begin(), origins_.end(), "*") != origins_.end(); }

bool CorsPolicy::allows(const std::string& origin) const {
  return !origin.empty() && (any() || std::find(origins_.begin(), origins_.end(), origin) != origins_.end());
}

std::vector<std::pair<std::string, std::string>> CorsPolicy::fields(const RequestHead& head) const {
  std::vector<std::pair<std::string, std::string>> fields;
  if (origins_.empty()) return fields;
  // A shared cache must not give the answer to another origin.
  if (!any()) fields.emplace_back("Vary", "Origin");
  const std::string origin = head.field("origin");
  if (!allows(origin)) return fields;
  fields.emplace_back("Access-Control-Allow-Origin", any() ? "*" : origin);
  fields.emplace_back("Access-Control-Expose-Headers", kExposedFields);
  return fields;
}

std::optional<Response> CorsPolicy::preflight(const RequestHead& head) const {
  if (origins_.empty() || head.method != "OPTIONS" || head.field("origin").empty() ||
      head.field("access-control-request-method").empty() || head.has_body())
    return std::nullopt;
  Response response;
  response.status = 204;
  if (!allows(head.field("origin"))) return response;
  response.headers = {{"Access-Control-Allow-Methods", kMethods},
                      {"Access-Control-Allow-Headers", kRequestFields},
                      {"Access-Control-Max-Age", kMaxAge}};
  return response;
}

}  // namespace fracture::http
