// Fuzz target: the client address of a request. The first byte chooses between the header of the PROXY
// protocol and a Forwarded field behind proxies of a network that the first line names. The result is always
// a valid address, whatever strangers write, and only a named proxy is believed.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "server/http/client_address.hpp"

namespace {

using namespace fracture::http;

void require(bool condition) {
  if (!condition) std::abort();
}

void check_proxy_header(std::string_view received) {
  const ProxyHeader header = parse_proxy_header(received);
  if (header.state == ProxyHeader::State::kThere) {
    require(header.size > 0 && header.size <= received.size());
    if (!header.address.empty()) {
      const auto address = parse_address(header.address);
      require(address.has_value());
      require(parse_address(to_string(*address)) == address);
    }
  } else {
    require(header.address.empty());
  }
  // Independent of how the bytes are cut into packets: a prefix is incomplete, or already has the same result
  // as the whole.
  for (const std::size_t part : {received.size() / 2, received.size() - received.size() / 4}) {
    const ProxyHeader begun = parse_proxy_header(received.substr(0, part));
    if (begun.state == ProxyHeader::State::kIncomplete) continue;
    require(begun.state == header.state && begun.size == header.size && begun.address == header.address);
  }
}

void check_forwarded(std::string_view text) {
  const std::size_t line = text.find('\n');
  const std::string_view network = text.substr(0, line);
  const std::string_view field = line == std::string_view::npos ? std::string_view() : text.substr(line + 1);
  const std::string peer = "192.0.2.7";
  TrustedProxies nobody, named;
  require(forwarded_client(peer, field, nobody) == peer);
  if (named.add(network)) require(!named.empty());
  const std::string client = forwarded_client(peer, field, named);
  if (!named.contains(peer)) require(client == peer);
  require(parse_address(client).has_value());
  // A proxy appends its client last, so whatever precedes it does not matter.
  TrustedProxies only;
  require(only.add("192.0.2.0/24"));
  require(forwarded_client(peer, std::string(field) + ", for=198.51.100.7", only) == "198.51.100.7");
  require(client_of(client_of(client)) == client_of(client));
  if (const auto address = parse_address(field)) require(parse_address(to_string(*address)) == address);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] & 1)
    check_proxy_header(rest);
  else
    check_forwarded(rest);
  return 0;
}
