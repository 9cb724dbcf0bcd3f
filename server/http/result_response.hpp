// A result as an HTTP answer.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "server/http/message.hpp"
#include "server/service/service.hpp"

namespace fracture::http {

/// The answer for a result in the negotiated representation, with the headers that depend on the result only.
Response result_response(const std::shared_ptr<const FractureResult>& result, std::size_t representation);

/// RFC 9211: the caches in the order the request meets them, nearest to the computation first.
std::string cache_status(const FractureAnswer& answer);

/// Milliseconds in the queue and of each stage, those that did not run as 0.
std::string server_timing(const FractureAnswer& answer);

}  // namespace fracture::http
