// Finds the client of a request that arrives through proxies. Forwarded (RFC 7239) and the PROXY protocol
// (haproxy.org, versions 1 and 2) are only trusted from proxies that the operator has named, because any
// client can send them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fracture::http {

/// An IPv4 or IPv6 address. IPv4 addresses are stored as ::ffff:a.b.c.d.
using Address = std::array<std::uint8_t, 16>;

/// Parses a numeric address without port or zone.
std::optional<Address> parse_address(std::string_view text);
std::string to_string(const Address& address);

/// Returns what counts as one client: an IPv4 address, or the /64 of an IPv6 address, because a single
/// subscriber can use all addresses in a /64. Text that is not an address is returned unchanged.
std::string client_of(const std::string& address);

/// Networks, as "192.0.2.0/24", "2001:db8::/32" or single addresses.
class TrustedProxies {
 public:
  /// Returns false and changes nothing if `cidr` is not a network; bits beyond the prefix must be 0.
  bool add(std::string_view cidr);
  bool contains(const std::string& address) const;
  bool empty() const { return networks_.empty(); }

 private:
  struct Network {
    Address address;
    int bits;
  };
  std::vector<Network> networks_;
};

/// Returns the client of a request from `peer` with this Forwarded field (all its lines, joined by commas).
/// Each proxy appends the address that called it, so the list is followed from its end for as long as the
/// proxies are trusted. Earlier elements may be forged by the client and have no effect, even if they contain
/// an open quote. If a proxy gives no address ("unknown", "_hidden"), that proxy counts as the client.
std::string forwarded_client(const std::string& peer, std::string_view forwarded,
                             const TrustedProxies& proxies);

/// The header of the PROXY protocol at the start of a connection.
struct ProxyHeader {
  enum class State { kAbsent, kIncomplete, kMalformed, kThere };
  State state = State::kAbsent;
  std::size_t size = 0;  ///< size of the header if there is one
  std::string address;   ///< of the client; empty if the proxy speaks for itself (UNKNOWN, LOCAL)
};
ProxyHeader parse_proxy_header(std::string_view received);

}  // namespace fracture::http
