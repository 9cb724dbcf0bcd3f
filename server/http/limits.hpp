// Limits for connections. All are finite by default, each has a flag of `fracture-server serve`, and GET
// /limits lists them.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace fracture::http {

struct HttpLimits {
  std::uint64_t max_body = 64ull << 20;           ///< bytes of a request body
  std::uint64_t max_decoded_body = 256ull << 20;  ///< bytes of a request body after its Content-Encoding
  std::uint64_t max_bodies =
      512ull << 20;  ///< bytes of all bodies over kSmallBody that are held at the same time
  std::uint64_t max_small_bodies = 64ull << 20;  ///< of all others: they never wait for large uploads
  /// Part of max_bodies for one client address. It gets the same fraction of max_small_bodies. 0: a quarter.
  std::uint64_t max_bodies_per_address = 0;
  std::uint64_t max_answers = 512ull << 20;   ///< bytes of all answers that clients have not read completely
  std::uint64_t max_answers_per_address = 0;  ///< part of max_answers for one client address; 0: a quarter
  std::uint64_t answer_ledger = 64ull << 20;  ///< bytes of the ledger that maps answers to names
  std::size_t max_header = 16u << 10;         ///< bytes of request line and fields together
  std::size_t max_uri = 4u << 10;             ///< bytes of the request target
  std::chrono::milliseconds header_timeout{
      5'000};                                   ///< from the first byte of a request to the end of its header
  std::chrono::milliseconds body_grace{5'000};  ///< a body may be slower than the rate for this long
  std::uint64_t body_rate = 16u << 10;  ///< minimum average bytes per second of a body after that time
  std::chrono::milliseconds body_timeout{600'000};  ///< for a whole body, even if it keeps the rate
  /// Minimum average bytes per second at which a client must read its answer, after write_stall.
  std::uint64_t answer_rate = 16u << 10;
  std::chrono::milliseconds write_stall{15'000};  ///< longest time without the client reading a byte
  std::chrono::milliseconds idle{15'000};         ///< between requests on a keep-alive connection
  std::chrono::milliseconds deadline{60'000};     ///< from the complete request to the end of its computation
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

/// Bodies up to this size, as sent, count as small. Answers up to kSmallAnswer are not counted in
/// max_answers, but with their connections.
inline constexpr std::uint64_t kSmallBody = 64u << 10;
inline constexpr std::uint64_t kSmallAnswer = 64u << 10;

/// Maximum numbers of fields in a header, and of commas and semicolons in all its fields. Each part is
/// inspected, some of them several times: 16 KiB of commas took an io thread half a millisecond. Browsers and
/// proxies send about 30 fields and 60 members.
inline constexpr std::size_t kMaxFields = 128, kMaxMembers = 512;

// An io thread works for at most 0.2 ms on one client before it serves the others (fracture_io_turn_seconds).
// Larger work is done on the pool, where each client has its share.

/// Bodies up to kReadInline are hashed on the io thread. This takes 0.03 ms with SHA instructions, which is
/// less than switching to another thread and back under load. Bodies with a digest are hashed up to three
/// times, also with SHA-512, for which there are no such instructions, so their limit is lower.
inline constexpr std::size_t kReadInline = 64u << 10, kDigestInline = 4u << 10;
/// Queries and bodies with up to this many bytes of parameters in total are parsed and turned into cache keys
/// on the io thread, in 0.1 ms. Entries of `assign` and unknown names take longer, and count as more bytes
/// (parameter_weight.hpp). For parameters of an earlier answer, which are already parsed, the limit is
/// kEarlierInline.
inline constexpr std::uint64_t kParseInline = 512, kEarlierInline = 1u << 10;
/// Maximum bytes hashed, inflated or sorted in one turn, or work that takes as long: a body with its cache
/// keys, and the client's token. Anything larger counts as a bug (HttpServer::bulk_turns).
inline constexpr std::size_t kMostInTurn = 2 * kReadInline;

/// Maximum bytes of a body that is a JSON object of parameters.
inline constexpr std::uint64_t kMaxSmallBody = 64u << 10;

/// Size of the read buffer, which also limits a chunk header with its extensions and a trailer section. With
/// an unbounded buffer, Boost.Beast throws or grows without limit.
inline constexpr std::size_t kReadBuffer = 64u << 10;
/// Maximum bytes that the kernel queues beyond what the client's window allows. Without this limit, it queues
/// megabytes for each slow client; copying them for five hundred clients would cost the io thread seconds.
inline constexpr int kMaxUnsent = 128 << 10;
/// Maximum bytes of an answer that are passed to the kernel in one turn.
inline constexpr std::size_t kMaxWritten = 64u << 10;
/// Memory of one connection, whatever its client does, with a small answer. Bodies and larger answers are
/// counted separately.
inline constexpr std::uint64_t kConnectionBytes = kReadBuffer + kMaxUnsent + kSmallAnswer;

}  // namespace fracture::http
