// One connection: reads requests one after another, hands them to the Api, writes the answers.
#pragma once

#include "server/http/api.hpp"
#include "server/http/asio.hpp"
#include "server/http/auth.hpp"
#include "server/http/client_address.hpp"
#include "server/http/connections.hpp"
#include "server/http/cors.hpp"
#include "server/http/site_policy.hpp"

namespace fracture::http {

/// Who may ask on the public listener.
struct Policy {
  tenants::Accounts accounts;
  TrustedProxies proxies;
  CorsPolicy cors;
  SitePolicy sites;  ///< asked where no token is required

  /// A proxy's connections are those of many clients.
  Connections::OfClient limit_of(const std::string& address) const {
    return proxies.contains(address) ? Connections::OfClient::kUnlimited : Connections::OfClient::kLimited;
  }
};

/// What the sessions of a listener share; the references outlive them.
struct SessionContext {
  Listener listener;
  Api& api;
  Connections& connections;
  const Policy& policy;
};

/// Starts a session that owns the socket, on the socket's executor (a strand), and its place among the connections. A
/// verdict other than kWelcome makes it answer one refusal and close.
void start_session(tcp::socket socket, const SessionContext& context, Connections::Arrival arrival,
                   const std::string& address);

}  // namespace fracture::http
