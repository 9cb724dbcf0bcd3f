// What a connection may cost. Finite by default, each a flag of `fracture-server serve`, published at GET
// /limits.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace fracture::http {

struct HttpLimits {
  std::uint64_t max_body = 64ull << 20;           ///< bytes of a request body
  std::uint64_t max_decoded_body = 256ull << 20;  ///< bytes of a request body after its Content-Encoding
  std::uint64_t max_bodies =
      512ull << 20;  ///< bytes of all request bodies over kSmallBody that are held at the same time
  std::uint64_t max_small_bodies = 64ull << 20;  ///< of all others: they never wait for large uploads
  /// Of max_bodies, for one client address; of max_small_bodies it has the same fraction. 0: a quarter.
  std::uint64_t max_bodies_per_address = 0;
  std::uint64_t max_answers = 512ull << 20;   ///< bytes of all answers that are on their way
  std::uint64_t max_answers_per_address = 0;  ///< of that, for one client address; 0: a quarter
  std::uint64_t answer_ledger = 64ull << 20;  ///< bytes of the ledger of which name has made which answer
  std::size_t max_header = 16u << 10;         ///< bytes of request line and fields together
  std::size_t max_uri = 4u << 10;             ///< bytes of the request target
  std::chrono::milliseconds header_timeout{
      5'000};                                   ///< from the first byte of a request to the end of its header
  std::chrono::milliseconds body_grace{5'000};  ///< a body may be slower than the rate for this long
  std::uint64_t body_rate = 16u << 10;  ///< bytes a second that a body must keep up on average after that
  std::chrono::milliseconds body_timeout{600'000};  ///< for a whole body, however fast it is
  /// Bytes a second at which a client must take its answer on average, after write_stall.
  std::uint64_t answer_rate = 16u << 10;
  std::chrono::milliseconds write_stall{
      15'000};                             ///< longest time without the client taking a byte of the answer
  std::chrono::milliseconds idle{15'000};  ///< between requests on a kept connection
  std::chrono::milliseconds deadline{60'000};  ///< from the complete request to the end of its computation
  std::chrono::milliseconds realtime_deadline{2'000};  ///< the same for realtime work
  std::size_t max_connections = 1024;
  std::size_t max_connections_per_address = 64;

  std::uint64_t body_share() const {
    return max_bodies_per_address ? max_bodies_per_address : max_bodies / 4;
  }
  std::uint64_t answer_share() const {
    return max_answers_per_address ? max_answers_per_address : max_answers / 4;
  }
};

/// Bytes of a body, as it is sent, that still counts as small; and of an answer that is not counted.
inline constexpr std::uint64_t kSmallBody = 64u << 10;
inline constexpr std::uint64_t kSmallAnswer = 64u << 10;

/// Of a header: its fields, and the commas and semicolons in all of them. Each part is looked at for itself, some of them
/// several times: 16 KiB of commas took an io thread half a millisecond. Browsers and proxies send 30 fields and 60 members.
inline constexpr std::size_t kMaxFields = 128, kMaxMembers = 512;

// What an io thread does for one client before it serves the others takes 0.2 ms at most
// (fracture_io_turn_seconds); everything beyond these sizes is done on the pool, where each client has its part.

/// Bodies up to this size are hashed on the io thread: 0.03 ms with the SHA instructions of current processors, less
/// than the way to another thread and back costs under load. Bodies that announce their digest are hashed up to three
/// times, by SHA-512 too, which has no instructions of its own.
inline constexpr std::size_t kReadInline = 64u << 10, kDigestInline = 4u << 10;
/// Parameters up to so many bytes of query and body together are read, and made a name in the caches, there: 0.1 ms. Those
/// of an earlier answer that they name were read before.
inline constexpr std::uint64_t kParseInline = 512, kEarlierInline = 1u << 10;
/// Bytes that are hashed, inflated or sorted in one turn, or what takes as long: a body, with its names in the caches and
/// the token of its client. More is counted as a bug (HttpServer::bulk_turns).
inline constexpr std::size_t kMostInTurn = 2 * kReadInline;

/// Bytes of a body that is a JSON object of parameters.
inline constexpr std::uint64_t kMaxSmallBody = 4u << 10;

/// Bound of the read buffer, which also bounds a chunk header with its extensions and a trailer section:
/// Boost.Beast throws or grows without limit when its buffer is unbounded.
inline constexpr std::size_t kReadBuffer = 64u << 10;
/// Bytes that the kernel takes ahead of what the client's window lets it send. Without a bound it takes
/// megabytes of an answer for each client that reads slowly: five hundred of them cost the io thread seconds
/// of copying.
inline constexpr int kMaxUnsent = 128 << 10;
/// Bytes of an answer that are handed to the kernel in one turn.
inline constexpr std::size_t kMaxWritten = 64u << 10;
/// Of a connection, whatever its client does: beside bodies and answers, which are counted for themselves.
inline constexpr std::uint64_t kConnectionBytes = kReadBuffer + kMaxUnsent;

}  // namespace fracture::http
