// What the log says of a request and of its answer.
#pragma once

#include "server/http/message.hpp"
#include "server/ops/request_record.hpp"

namespace fracture::http {

/// Method, path and trace.
void note_request(ops::RequestRecord& record, const RequestHead& head);

/// Status, bytes, caches, and the mesh of a result.
void note_answer(ops::RequestRecord& record, const Response& response);

}  // namespace fracture::http
