// Ids of requests for logs and answers.
#pragma once

#include <string>

#include "server/http/request_head.hpp"

namespace fracture::http {

/// Returns 16 hex digits that are unique in this process.
std::string new_request_id();

/// Returns the client's X-Request-Id if it is safe to log and to send back (1 to 64 letters, digits or
/// "-_."), else a new id.
std::string request_id(const RequestHead& head);

/// W3C Trace Context: the trace that the request belongs to, and the sender's span.
struct TraceContext {
  std::string trace_id;   ///< 32 hex digits; empty if there is no well-formed traceparent
  std::string parent_id;  ///< 16 hex digits
};
TraceContext trace_context(const RequestHead& head);

}  // namespace fracture::http
