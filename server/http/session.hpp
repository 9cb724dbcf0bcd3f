// One connection: reads requests one after another, hands them to the Api, writes the answers.
#pragma once

#include <memory>

#include "server/http/api.hpp"
#include "server/http/asio.hpp"
#include "server/http/connections.hpp"

namespace fracture::http {

/// Starts a session that owns the socket, on the socket's executor (a strand). `verdict` other than kWelcome
/// makes it answer one refusal and close. The connection must have been added to `connections`; the session
/// removes it.
void start_session(tcp::socket socket, Listener listener, Api& api, Connections& connections,
                   Connections::Verdict verdict, const std::string& address);

}  // namespace fracture::http
