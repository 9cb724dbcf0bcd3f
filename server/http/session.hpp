// One connection: reads requests one after another, passes them to the Api and writes the answers.
#pragma once

#include "server/http/api.hpp"
#include "server/http/asio.hpp"
#include "server/http/auth.hpp"
#include "server/http/client_address.hpp"
#include "server/http/connections.hpp"
#include "server/http/cors.hpp"
#include "server/http/io_turns.hpp"
#include "server/http/site_policy.hpp"

namespace fracture::http {

/// Access rules of the public listener.
struct Policy {
  tenants::Accounts accounts;
  TrustedProxies proxies;
  CorsPolicy cors;
  SitePolicy sites;  ///< applied if no token is required

  /// A proxy's connections belong to many clients.
  Connections::OfClient limit_of(const std::string& address) const {
    return proxies.contains(address) ? Connections::OfClient::kUnlimited : Connections::OfClient::kLimited;
  }
};

/// Data shared by the sessions of a listener. The references outlive the sessions.
struct SessionContext {
  Listener listener;
  Api& api;
  Connections& connections;
  const Policy& policy;
  IoTurns* turns = nullptr;  ///< null: requests do not wait for a turn
};

/// Starts a session, which owns the socket and its place among the connections. It runs on the socket's
/// executor (a strand). With a verdict other than kWelcome, it sends one refusal and closes.
void start_session(tcp::socket socket, const SessionContext& context, Connections::Arrival arrival,
                   const std::string& address);

}  // namespace fracture::http
