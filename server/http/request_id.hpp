// How a request is named in logs and answers.
#pragma once

#include <string>

#include "server/http/request_head.hpp"

namespace fracture::http {

/// 16 hex digits that no other request of this process has.
std::string new_request_id();

/// The client's own X-Request-Id when it is harmless to log and to send back (1 to 64 letters, digits or
/// "-_."), else a new one.
std::string request_id(const RequestHead& head);

/// W3C Trace Context: the trace that a request belongs to, and the span of whoever sent it.
struct TraceContext {
  std::string trace_id;   ///< 32 hex digits; empty when the request has no well-formed traceparent
  std::string parent_id;  ///< 16 hex digits
};
TraceContext trace_context(const RequestHead& head);

}  // namespace fracture::http
