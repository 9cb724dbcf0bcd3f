// Content-Digest of requests (RFC 9530): what the client says its body hashes to.
#pragma once

#include <optional>
#include <string_view>

#include "common/base/execution.hpp"
#include "server/http/problem.hpp"

namespace fracture::http {

/// Compares the body, as it was sent, with the sha-256 and sha-512 of the field; other algorithms are ignored,
/// as that standard wants. Throws Interrupted. Refuses a mismatch (400 content-digest-mismatch) and a field that is no
/// dictionary of byte sequences (RFC 8941).
std::optional<Problem> check_content_digest(std::string_view field, std::string_view body,
                                            const Execution& execution = kUninterrupted);

}  // namespace fracture::http
