// Who a request comes from when proxies stand in between. What they say of their clients, in Forwarded (RFC
// 7239) or in the PROXY protocol (haproxy.org, versions 1 and 2), is believed only of those that the operator
// named: anybody can send such a field.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fracture::http {

/// An IPv4 or IPv6 address; IPv4 as IPv6 sees it (::ffff:a.b.c.d).
using Address = std::array<std::uint8_t, 16>;

/// Numeric forms only, without port or zone.
std::optional<Address> parse_address(std::string_view text);
std::string to_string(const Address& address);

/// What counts as one client: an IPv4 address, or the /64 of an IPv6 one, which is what a single subscriber
/// gets to choose its addresses from. Text that is no address is returned as it is.
std::string client_of(const std::string& address);

/// Networks, as "192.0.2.0/24", "2001:db8::/32" or single addresses.
class TrustedProxies {
 public:
  /// False, and nothing changes, for what is no network (bits beyond the prefix must be 0).
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

/// The client of a request that came from `peer` with this Forwarded field (all its lines, joined by commas):
/// each proxy adds who it was asked by, so the list is read and followed from its end as far as the proxies are
/// trusted. What stands before that the client may have written: it changes nothing, whatever it leaves open. If a
/// proxy says something that is no address ("unknown", "_hidden"), that proxy counts as the client.
std::string forwarded_client(const std::string& peer, std::string_view forwarded,
                             const TrustedProxies& proxies);

/// The header of the PROXY protocol, at the beginning of a connection.
struct ProxyHeader {
  enum class State { kAbsent, kIncomplete, kMalformed, kThere };
  State state = State::kAbsent;
  std::size_t size = 0;  ///< of the header, when it is there
  std::string address;   ///< of the client; empty when the proxy speaks for itself (UNKNOWN, LOCAL)
};
ProxyHeader parse_proxy_header(std::string_view received);

}  // namespace fracture::http
