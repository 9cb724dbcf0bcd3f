#include "server/http/request_notes.hpp"

#include <string>
#include <string_view>

#include "server/http/request_id.hpp"

namespace fracture::http {
namespace {

/// Returns the value of the first field with this name, or an empty string.
std::string field_of(const Response& response, std::string_view name) {
  for (const auto& [key, value] : response.headers)
    if (equals_ignoring_case(key, name)) return value;
  return "";
}

/// Returns the first digits of the mesh digest, with which the name of every result begins.
std::string mesh_of(const Response& response) {
  constexpr std::string_view kResults = "/fractures/sha256:";
  const std::string location = field_of(response, "content-location");
  return location.starts_with(kResults) ? location.substr(kResults.size(), 16) : "";
}

}  // namespace

void note_request(ops::RequestRecord& record, const RequestHead& head) {
  const TraceContext trace = trace_context(head);
  record.trace_id = trace.trace_id;
  record.parent_id = trace.parent_id;
  record.method = head.method;
  record.path = head.path;
}

void note_answer(ops::RequestRecord& record, const Response& response) {
  record.status = response.status;
  record.bytes_out = response.body.size();
  record.cache = field_of(response, "cache-status");
  record.mesh = mesh_of(response);
}

}  // namespace fracture::http
