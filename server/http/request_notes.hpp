// Fills the log record of a request and its answer.
#pragma once

#include "server/http/message.hpp"
#include "server/ops/request_record.hpp"

namespace fracture::http {

/// Notes the method, path and trace.
void note_request(ops::RequestRecord& record, const RequestHead& head);

/// Notes the status, bytes, cache use, and the mesh of a result.
void note_answer(ops::RequestRecord& record, const Response& response);

}  // namespace fracture::http
