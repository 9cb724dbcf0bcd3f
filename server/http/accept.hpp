// Content negotiation by the Accept field (RFC 9110, section 12.5.1).
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace fracture::http {

/// Returns the index of the offered media type that the client prefers, or nothing if it accepts none. The
/// earlier offer wins a tie. An empty field accepts everything; a more specific range overrides a wider one;
/// malformed items are skipped.
std::optional<std::size_t> negotiate(std::string_view accept, std::span<const std::string_view> offers);

/// Parses a qvalue (RFC 9110, section 12.4.2) into thousandths: "0.5" is 500. Returns -1 if malformed.
int thousandths(std::string_view q);

}  // namespace fracture::http
