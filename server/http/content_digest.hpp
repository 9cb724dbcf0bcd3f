// Content-Digest of requests (RFC 9530): the hash that the client gives for its body.
#pragma once

#include <optional>
#include <string_view>

#include "common/base/execution.hpp"
#include "server/http/problem.hpp"

namespace fracture::http {

/// Compares the body, as it was sent, with the sha-256 and sha-512 values in the field. Other algorithms are
/// ignored, as the standard requires. Refuses a mismatch (400 content-digest-mismatch) and a field that is
/// not a dictionary of byte sequences (RFC 8941). Throws Interrupted.
std::optional<Problem> check_content_digest(std::string_view field, std::string_view body,
                                            const Execution& execution = kUninterrupted);

}  // namespace fracture::http
