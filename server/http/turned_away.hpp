// The problems of requests that find no place or no turn.
#pragma once

#include "server/http/connections.hpp"
#include "server/http/limits.hpp"
#include "server/http/problem.hpp"

namespace fracture::http {

/// For a connection that was not welcome.
Problem turned_away(Connections::Verdict verdict, const HttpLimits& limits);
Problem too_many_connections(const HttpLimits& limits);
/// For a request whose turn on the I/O threads has not come in time, or (`gives_way`) whose connection is
/// needed for another client.
Problem turn_too_late(bool gives_way, const HttpLimits& limits);

}  // namespace fracture::http
