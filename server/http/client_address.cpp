#include "server/http/client_address.hpp"
#include "common/base/text.hpp"
#include "server/http/authority.hpp"

#include <arpa/inet.h>
#include <strings.h>

#include <algorithm>
#include <charconv>

namespace fracture::http {
namespace {

constexpr std::array<std::uint8_t, 12> kMapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};

bool is_v4(const Address& address) { return std::equal(kMapped.begin(), kMapped.end(), address.begin()); }

bool same_prefix(const Address& a, const Address& b, int bits) {
  for (int k = 0; k < 16 && bits > 0; ++k, bits -= 8) {
    const auto mask = static_cast<std::uint8_t>(bits >= 8 ? 0xff : 0xff << (8 - bits));
    if ((a[static_cast<std::size_t>(k)] & mask) != (b[static_cast<std::size_t>(k)] & mask)) return false;
  }
  return true;
}

/// Splits a list; quoted strings stay whole.
std::vector<std::string_view> split(std::string_view list, char separator) {
  std::vector<std::string_view> pieces;
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= list.size(); ++k) {
    if (k == list.size() || (list[k] == separator && !quoted)) {
      pieces.push_back(trimmed(list.substr(begin, k - begin)));
      begin = k + 1;
    } else if (list[k] == '"') {
      quoted = !quoted;
    } else if (list[k] == '\\' && quoted) {
      ++k;
    }
  }
  return pieces;
}

/// Removes the last element from the list and returns it. The list is read from its end, which the nearest
/// proxy has written, so a quote that the client left open cannot extend beyond the client's own text.
std::string_view take_last(std::string_view& list) {
  const auto is_escaped = [&list](std::size_t quote) {
    const std::size_t before = list.substr(0, quote).find_last_not_of('\\');
    return (quote - (before == std::string_view::npos ? 0 : before + 1)) % 2 == 1;
  };
  bool quoted = false;
  std::size_t begin = list.size();
  for (; begin > 0; --begin) {
    const char c = list[begin - 1];
    if (c == ',' && !quoted) break;
    if (c == '"' && !is_escaped(begin - 1)) quoted = !quoted;
  }
  const std::string_view element = list.substr(begin);
  list = list.substr(0, begin == 0 ? 0 : begin - 1);
  return quoted ? std::string_view() : trimmed(element);  // an unopened quote: not valid
}

/// Parses 192.0.2.1, "192.0.2.1:80", "[2001:db8::1]:80" or "[2001:db8::1]:_port".
std::optional<Address> address_of(std::string_view node) {
  if (node.size() >= 2 && node.front() == '"' && node.back() == '"') node = node.substr(1, node.size() - 2);
  // RFC 7239, section 6.3: a port may be replaced by an obfuscated name.
  if (const std::size_t hidden = node.rfind(":_"); hidden != std::string_view::npos)
    node = node.substr(0, hidden);
  const std::optional<Authority> authority = authority_in(node);
  if (!authority) return std::nullopt;
  const std::string_view host = authority->host;
  return parse_address(host.front() == '[' ? host.substr(1, host.size() - 2) : host);
}

/// Returns the address after `for=` in one element. Returns nothing if it is not an address or is given
/// twice.
std::optional<Address> node_of(std::string_view element) {
  std::optional<std::string_view> node;
  for (const std::string_view pair : split(element, ';')) {
    if (pair.size() < 4 || ::strncasecmp(pair.data(), "for=", 4) != 0) continue;
    if (node) return std::nullopt;
    node = trimmed(pair.substr(4));
  }
  return node ? address_of(*node) : std::nullopt;
}

}  // namespace

std::optional<Address> parse_address(std::string_view text) {
  if (text.size() > 45) return std::nullopt;
  const std::string zero_ended(text);
  Address address{};
  if (::inet_pton(AF_INET6, zero_ended.c_str(), address.data()) == 1) return address;
  if (::inet_pton(AF_INET, zero_ended.c_str(), address.data() + 12) != 1) return std::nullopt;
  std::copy(kMapped.begin(), kMapped.end(), address.begin());
  return address;
}

std::string to_string(const Address& address) {
  char text[INET6_ADDRSTRLEN];
  if (is_v4(address))
    ::inet_ntop(AF_INET, address.data() + 12, text, sizeof text);
  else
    ::inet_ntop(AF_INET6, address.data(), text, sizeof text);
  return text;
}

std::string client_of(const std::string& address) {
  std::optional<Address> parsed = parse_address(address.substr(0, address.find('%')));
  if (!parsed) return address;
  if (is_v4(*parsed)) return to_string(*parsed);
  std::fill(parsed->begin() + 8, parsed->end(), std::uint8_t{0});
  return to_string(*parsed) + "/64";
}

bool TrustedProxies::add(std::string_view cidr) {
  const std::size_t slash = cidr.find('/');
  const std::optional<Address> address = parse_address(cidr.substr(0, slash));
  if (!address) return false;
  const bool v4 = cidr.substr(0, slash).find(':') == std::string_view::npos;
  int bits = v4 ? 32 : 128;
  if (slash != std::string_view::npos) {
    const std::string_view digits = cidr.substr(slash + 1);
    int given = -1;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), given);
    if (digits.empty() || error != std::errc() || end != digits.data() + digits.size() || given < 0 ||
        given > bits)
      return false;
    bits = given;
  }
  if (v4) bits += 96;
  Address masked{};
  for (int k = 0; k < bits; ++k)
    masked[static_cast<std::size_t>(k / 8)] |=
        static_cast<std::uint8_t>((*address)[static_cast<std::size_t>(k / 8)] & (0x80 >> (k % 8)));
  if (masked != *address) return false;
  networks_.push_back({*address, bits});
  return true;
}

bool TrustedProxies::contains(const std::string& address) const {
  if (networks_.empty()) return false;
  const std::optional<Address> parsed = parse_address(address.substr(0, address.find('%')));
  return parsed && std::any_of(networks_.begin(), networks_.end(), [&](const Network& network) {
           return same_prefix(*parsed, network.address, network.bits);
         });
}

std::string forwarded_client(const std::string& peer, std::string_view forwarded,
                             const TrustedProxies& proxies) {
  std::string client = peer;
  while (!forwarded.empty() && proxies.contains(client)) {
    const std::optional<Address> node = node_of(take_last(forwarded));
    if (!node) break;
    client = to_string(*node);
  }
  return client;
}

namespace {

/// Parses "PROXY TCP4 192.0.2.1 192.0.2.2 1234 80\r\n", at most 107 bytes.
ProxyHeader parse_text(std::string_view received) {
  constexpr std::size_t kLongest = 107;
  using enum ProxyHeader::State;
  const std::size_t end = received.substr(0, kLongest).find("\r\n");
  if (end == std::string_view::npos) return {received.size() >= kLongest ? kMalformed : kIncomplete, 0, ""};
  ProxyHeader header{kThere, end + 2, ""};
  const std::vector<std::string_view> words = split(received.substr(0, end), ' ');
  if (words.size() >= 2 && words[1] == "UNKNOWN") return header;
  if (words.size() != 6 || (words[1] != "TCP4" && words[1] != "TCP6")) return {kMalformed, 0, ""};
  const std::optional<Address> source = parse_address(words[2]);
  if (!source || !parse_address(words[3])) return {kMalformed, 0, ""};
  header.address = to_string(*source);
  return header;
}

/// Parses the signature, version and command, family and length, then the addresses and any data after them.
ProxyHeader parse_binary(std::string_view received) {
  using enum ProxyHeader::State;
  constexpr std::size_t kFixed = 16, kLongest = 4096;
  if (received.size() < kFixed) return {kIncomplete, 0, ""};
  const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>(received[k]); };
  const std::size_t size = kFixed + (std::size_t{byte(14)} << 8 | byte(15));
  const int command = byte(12) & 15, family = byte(13) >> 4;
  if (byte(12) >> 4 != 2 || command > 1 || size > kLongest) return {kMalformed, 0, ""};
  if (received.size() < size) return {kIncomplete, 0, ""};
  ProxyHeader header{kThere, size, ""};
  if (command == 0 || family == 0 || family == 3) return header;  // LOCAL, unspecified, or a Unix socket
  if (family > 3 || size < kFixed + (family == 1 ? 12u : 36u)) return {kMalformed, 0, ""};
  Address source{};
  const auto begin = received.begin() + kFixed;
  if (family == 1) {
    std::copy(kMapped.begin(), kMapped.end(), source.begin());
    std::transform(begin, begin + 4, source.begin() + 12,
                   [](char c) { return static_cast<std::uint8_t>(c); });
  } else {
    std::transform(begin, begin + 16, source.begin(), [](char c) { return static_cast<std::uint8_t>(c); });
  }
  header.address = to_string(source);
  return header;
}

}  // namespace

ProxyHeader parse_proxy_header(std::string_view received) {
  constexpr std::string_view kText = "PROXY ", kBinary("\r\n\r\n\0\r\nQUIT\n", 12);
  for (const std::string_view signature : {kText, kBinary}) {
    const std::size_t common = std::min(signature.size(), received.size());
    if (received.substr(0, common) != signature.substr(0, common)) continue;
    if (common < signature.size()) return {ProxyHeader::State::kIncomplete, 0, ""};
    return signature == kText ? parse_text(received) : parse_binary(received);
  }
  return {};
}

}  // namespace fracture::http
