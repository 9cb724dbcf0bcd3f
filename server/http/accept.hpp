// Content negotiation by the Accept field (RFC 9110, section 12.5.1).
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace fracture::http {

/// Index of the offered media type that the client likes best (the earlier offer wins a tie); nothing when it
/// accepts none. An empty field accepts everything; a more specific range overrides a wider one; malformed
/// items are skipped.
std::optional<std::size_t> negotiate(std::string_view accept, std::span<const std::string_view> offers);

/// A qvalue (RFC 9110, section 12.4.2) in thousandths: "0.5" is 500; -1 when malformed.
int thousandths(std::string_view q);

}  // namespace fracture::http
