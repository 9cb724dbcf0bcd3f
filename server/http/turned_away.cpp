#include "server/http/turned_away.hpp"

#include <string>

namespace fracture::http {

Problem turned_away(Connections::Verdict verdict, const HttpLimits& limits) {
  if (verdict == Connections::Verdict::kFull)
    return Problem(
               ErrorCode::kOverloaded,
               "All connections of this server are in use (--max-connections). Try again after Retry-After.")
        .with("Retry-After", "2");
  return too_many_connections(limits);
}

Problem too_many_connections(const HttpLimits& limits) {
  return Problem(HttpProblem::kTooManyConnections, "This address has more than " +
                                                       std::to_string(limits.max_connections_per_address) +
                                                       " open connections, which is the limit. Close some.")
      .with("Retry-After", "2");
}

Problem turn_too_late(bool gives_way, const HttpLimits& limits) {
  if (gives_way) return turned_away(Connections::Verdict::kFull, limits);
  return Problem(ErrorCode::kOverloaded,
                 "The server was busy with other requests and could not begin this one within the time limit "
                 "for a header (--header-timeout). Try again after Retry-After.")
      .with("Retry-After", "2");
}

}  // namespace fracture::http
