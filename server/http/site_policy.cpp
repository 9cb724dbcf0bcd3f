#include "server/http/site_policy.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <utility>

#include "server/http/authority.hpp"

namespace fracture::http {
namespace {

/// Returns the host in "name[:port]" or "[address][:port]", the latter with its brackets, without a final
/// dot. Returns nothing if the text has neither form.
std::optional<std::string_view> name_in(std::string_view text) {
  const std::optional<Authority> authority = authority_in(text);
  if (!authority) return std::nullopt;
  std::string_view name = authority->host;
  if (name.size() > 1 && name.back() == '.') name.remove_suffix(1);
  return name;
}

/// Returns whether the name is an address. Addresses are safe, because only names can be rebound to another
/// address.
bool is_address(std::string_view name) {
  in6_addr parsed{};
  if (name.size() > 2 && name.front() == '[' && name.back() == ']')
    return ::inet_pton(AF_INET6, std::string(name.substr(1, name.size() - 2)).c_str(), &parsed) == 1;
  return ::inet_pton(AF_INET, std::string(name).c_str(), &parsed) == 1;
}

bool is_loopback_address(std::string_view name) {
  return name == "[::1]" || (is_address(name) && name.substr(0, 4) == "127.");
}

/// RFC 6761, section 6.3: these names always resolve to this machine.
bool is_localhost(std::string_view name) {
  constexpr std::string_view kName = "localhost", kBelow = ".localhost";
  return equals_ignoring_case(name, kName) ||
         (name.size() > kBelow.size() &&
          equals_ignoring_case(name.substr(name.size() - kBelow.size()), kBelow));
}

}  // namespace

bool SitePolicy::any_host() const { return std::find(hosts_.begin(), hosts_.end(), "*") != hosts_.end(); }

bool SitePolicy::is_ours(std::string_view name) const {
  return is_localhost(name) || std::any_of(hosts_.begin(), hosts_.end(), [name](const std::string& host) {
           return equals_ignoring_case(host, name);
         });
}

std::optional<Problem> SitePolicy::refuse(const RequestHead& head) const {
  const std::string host = head.field("host"), origin = head.field("origin");
  const std::optional<std::string_view> name = name_in(host);
  const bool known = name && (is_address(*name) || is_ours(*name));
  if (!host.empty() && !known && !any_host())
    return Problem(
        HttpProblem::kForeignHost,
        "The host '" + host.substr(0, 100) +
            "' is not a name of this server. A server without tokens accepts only requests to an IP "
            "address, to localhost or to a name given with --allow-host.");
  if (origin.empty() || cors_.allows(origin)) return std::nullopt;
  const std::size_t scheme = origin.find("://");
  const std::optional<std::string_view> site =
      scheme == std::string::npos ? std::nullopt : name_in(std::string_view(origin).substr(scheme + 3));
  if (site && (is_ours(*site) || is_loopback_address(*site) || (name && equals_ignoring_case(*site, *name))))
    return std::nullopt;
  return Problem(HttpProblem::kForeignOrigin,
                 "This request comes from a page on '" + origin.substr(0, 100) +
                     "'. Pages on other sites may send requests only if --cors-origin names their origin.");
}

}  // namespace fracture::http
