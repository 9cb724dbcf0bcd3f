// Decides which web pages may reach a server that requires no token. A browser gives pages access to its
// machine and network: any page can post a form to 127.0.0.1. With DNS rebinding (Jackson et al., "Protecting
// Browsers from DNS Rebinding Attacks", 2007) a page can even read the answer, because its own host name then
// resolves to this server. A page cannot forge Host and Origin, so both are checked.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/cors.hpp"
#include "server/http/request_head.hpp"

namespace fracture::http {

class SitePolicy {
 public:
  SitePolicy() = default;
  /// `hosts`: names without port under which clients reach this server; "*" allows all.
  SitePolicy(std::vector<std::string> hosts, CorsPolicy cors)
      : hosts_(std::move(hosts)), cors_(std::move(cors)) {}

  /// Returns 403 if Host is not an address, a name of this machine or an allowed name. Also returns 403 if
  /// Origin is none of these, differs from Host, and is not allowed by CORS. Requests without these fields do
  /// not come from a browser.
  std::optional<Problem> refuse(const RequestHead& head) const;

 private:
  bool any_host() const;
  bool is_ours(std::string_view name) const;
  std::vector<std::string> hosts_;
  CorsPolicy cors_;
};

}  // namespace fracture::http
