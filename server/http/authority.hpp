// Parses "host[:port]", as in a Host field, an Origin or a node of Forwarded. All of them are parsed here. If
// one parser accepted a host that another one reads as a host plus more text ("[::1]evil.example"), an
// attacker could pass for a trusted host.
#pragma once

#include <optional>
#include <string_view>

namespace fracture::http {

struct Authority {
  std::string_view host;  ///< a name, an IPv4 address, or an IPv6 address with its brackets; never empty
  std::string_view port;  ///< without its colon; empty when there is none
};

/// Returns nothing if the text is malformed: an empty host, brackets that are not closed or not at the ends
/// of the host, a second colon, or a port that is not one to five digits.
std::optional<Authority> authority_in(std::string_view text);

}  // namespace fracture::http
