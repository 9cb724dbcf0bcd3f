// Plain data: what a game sends to the service and receives from it. A mesh is stored once under the digest of its
// bytes; a collision is then a request of a few hundred bytes. Every request ends in exactly one Answer, whether
// it succeeds or fails.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/exchange/headers.hpp"
#include "common/exchange/stored_meshes.hpp"

namespace fracture::protocol {

/// The server's address and the time limits (the caller never waits; the client's own thread does).
struct Settings {
  std::string host = "127.0.0.1";
  std::uint16_t port = 8080;
  std::string token;            ///< sent as `Authorization: Bearer …` unless empty
  std::size_t connections = 4;  ///< maximum number of keep-alive connections; further requests wait for one
  Milliseconds connect_timeout{1000};
  Milliseconds answer_timeout{10'000};  ///< for one exchange, from first byte sent to last byte received
  Milliseconds patience{30'000};        ///< for one request, including all retries
  Milliseconds first_pause{50};         ///< before a retry if the server is absent; doubles …
  Milliseconds longest_pause{1000};     ///< … up to this
  Milliseconds idle{10'000};     ///< a connection unused for longer is replaced (the server's limit is 15 s)
  Milliseconds heartbeat{1000};  ///< sends GET /version after this long without requests; 0: never
  std::size_t max_answer_bytes = std::size_t{256} << 20;
  /// The server's realtime class, served before others and given up after two seconds. If false, its batch class.
  bool realtime = true;
  int damaged_answers = 3;  ///< a request fails after this many damaged answers
};

enum class RequestKind { kStore, kFracture, kPatterns };

/// The outcome of a request after all retries, by which a game decides. Each step has its own Error; `detail` keeps
/// the last one.
enum class Failure {
  kNone,
  kServerAbsent,  ///< no server listened, or connections broke, until the patience ran out
  kTimedOut,      ///< no answer in time
  kOverloaded,    ///< 429, 503: busy for longer than the patience
  kDamaged,       ///< repeatedly cut off, not HTTP, or not matching its digest
  kTooLarge,      ///< over max_answer_bytes, or parameters over kMaxParameterBytes
  kRefused,       ///< refused by the server: `problem` and `detail` say why
  kCancelled,     ///< by cancel() or because the client ended
};
const char* name(Failure failure);

using Ticket = std::uint64_t;  ///< identifies a request; never 0, never reused

struct Answer {
  Ticket ticket = 0;
  RequestKind kind = RequestKind::kFracture;
  Failure failure = Failure::kNone;
  int status = 0;       ///< of the last HTTP answer; 0 if there was none
  std::string problem;  ///< last segment of a problem's type: "bad-parameter"
  std::string detail;   ///< for people; empty on success
  std::string body;     ///< GLB or JSON; its digest has been checked
  /// Content-Location of fragments: "/fractures/sha256:…", for `of` in a later request
  std::string location;
  std::vector<StageTime> server_timing;
  double milliseconds = 0;  ///< from the call to the last byte, including all retries
  int exchanges = 0;        ///< number of HTTP requests sent
  bool ok() const { return failure == Failure::kNone; }
};

enum class ServerState { kUnknown, kReachable, kOverloaded, kAbsent };
const char* name(ServerState state);

/// Statistics for a panel.
struct Status {
  ServerState state = ServerState::kUnknown;
  std::string last_trouble;  ///< the latest error; empty if there was none
  std::size_t open = 0;      ///< requests without an answer yet
  std::uint64_t answered = 0, failed = 0, retried = 0, meshes_stored = 0, connections_made = 0;
  std::size_t fractures_timed = 0;     ///< number of latencies behind p50 and p99 (the last 512)
  double p50_ms = 0, p99_ms = 0;       ///< of successful fracture requests
  std::vector<StageTime> last_stages;  ///< Server-Timing of the latest of them
};

}  // namespace fracture::protocol
