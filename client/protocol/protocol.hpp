// What a game says to the service and hears from it: plain data. A mesh is stored once by the digest of its
// bytes; a collision is then a request of some hundred bytes. Every request ends in exactly one Answer, good
// or bad, whatever server and network do.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/exchange/headers.hpp"
#include "common/exchange/stored_meshes.hpp"

namespace fracture::protocol {

/// Where the server is, and how long it is waited for (never by the caller: by the client's own thread).
struct Settings {
  std::string host = "127.0.0.1";
  std::uint16_t port = 8080;
  std::string token;            ///< sent as `Authorization: Bearer …` where not empty
  std::size_t connections = 4;  ///< kept alive, at most; further requests wait for one of them
  Milliseconds connect_timeout{1000};
  Milliseconds answer_timeout{10'000};  ///< of one exchange: first byte sent to last byte received
  Milliseconds patience{30'000};        ///< of one request with all that is tried again
  Milliseconds first_pause{50};         ///< before trying again where nobody listens; doubles …
  Milliseconds longest_pause{1000};     ///< … up to this
  Milliseconds idle{10'000};     ///< a connection unused for longer is replaced (the server's limit is 15 s)
  Milliseconds heartbeat{1000};  ///< GET /version when nothing was asked for so long; 0: never
  std::size_t max_answer_bytes = std::size_t{256} << 20;
  /// The server's realtime class, which goes before others and is given up after two seconds. Without it: its batch class.
  bool realtime = true;
  int damaged_answers = 3;  ///< so many damaged answers to one request, and it has failed
};

enum class RequestKind { kStore, kFracture, kPatterns };

/// How a request has ended with all that was tried again: what a game decides by. Each step has an Error of its own,
/// of which `detail` keeps the last.
enum class Failure {
  kNone,
  kServerAbsent,  ///< nobody listened, or connections broke, until the patience was over
  kTimedOut,      ///< no answer in time
  kOverloaded,    ///< 429, 503: busy for longer than the patience
  kDamaged,       ///< cut off, not HTTP, or another digest than announced, again and again
  kTooLarge,      ///< over max_answer_bytes, or parameters over kMaxParameterBytes
  kRefused,       ///< the server's own no: `problem` and `detail` say why
  kCancelled,     ///< by cancel() or by the end of the client
};
const char* name(Failure failure);

using Ticket = std::uint64_t;  ///< of a request; never 0, never used twice

struct Answer {
  Ticket ticket = 0;
  RequestKind kind = RequestKind::kFracture;
  Failure failure = Failure::kNone;
  int status = 0;       ///< of the last HTTP answer; 0 where there was none
  std::string problem;  ///< last segment of a problem's type: "bad-parameter"
  std::string detail;   ///< for people; empty where all is well
  std::string body;     ///< GLB or JSON; its digest has been checked
  std::string
      location;  ///< Content-Location of fragments: "/fractures/sha256:…", which `of` of a further request names
  std::vector<StageTime> server_timing;
  double milliseconds = 0;  ///< from the call to the last byte, everything that was tried again included
  int exchanges = 0;        ///< HTTP requests that it took
  bool ok() const { return failure == Failure::kNone; }
};

enum class ServerState { kUnknown, kReachable, kOverloaded, kAbsent };
const char* name(ServerState state);

/// For a panel: what has been going on.
struct Status {
  ServerState state = ServerState::kUnknown;
  std::string last_trouble;  ///< the last thing that went wrong; empty where nothing has
  std::size_t open = 0;      ///< requests without an answer yet
  std::uint64_t answered = 0, failed = 0, retried = 0, meshes_stored = 0, connections_made = 0;
  std::size_t fractures_timed = 0;     ///< how many latencies p50 and p99 are of (the last 512)
  double p50_ms = 0, p99_ms = 0;       ///< of fracture requests that were answered well
  std::vector<StageTime> last_stages;  ///< Server-Timing of the last of them
};

}  // namespace fracture::protocol
