// Which web pages may reach a server that asks for no token. A browser is a way into the machine it runs on
// and the network around it: a page of any site may post a form to 127.0.0.1, and by DNS rebinding (Jackson
// et al., "Protecting Browsers from DNS Rebinding Attacks", 2007) even read the answer, since its own name
// then leads here. A browser cannot lie about Host and Origin, so these two are held to names that are ours.
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
  /// `hosts`: names without port by which clients call this server, or "*": any.
  SitePolicy(std::vector<std::string> hosts, CorsPolicy cors)
      : hosts_(std::move(hosts)), cors_(std::move(cors)) {}

  /// 403 for a Host that is neither an address, nor a name of this machine, nor an allowed one; and for an
  /// Origin that is none of these, nor the Host itself, nor one that CORS allows. A request without these
  /// fields comes from no browser.
  std::optional<Problem> refuse(const RequestHead& head) const;

 private:
  bool any_host() const;
  bool is_ours(std::string_view name) const;
  std::vector<std::string> hosts_;
  CorsPolicy cors_;
};

}  // namespace fracture::http
