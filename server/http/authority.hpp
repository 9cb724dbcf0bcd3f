// "host[:port]", as it is written in a Host field, in an Origin and in a node of Forwarded. All of them are read
// here: text that one reader takes for a host and another for a host with something behind it is how a stranger
// passes for a neighbour ("[::1]evil.example").
#pragma once

#include <optional>
#include <string_view>

namespace fracture::http {

struct Authority {
  std::string_view host;  ///< a name, an IPv4 address, or an IPv6 address with its brackets; never empty
  std::string_view port;  ///< without its colon; empty when there is none
};

/// Nothing for text of any other form: an empty host, brackets that are not closed or not at the ends of the host,
/// a second colon, a port that is not one to five digits.
std::optional<Authority> authority_in(std::string_view text);

}  // namespace fracture::http
