#include "server/http/content_coding.hpp"

#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "common/base/bulk.hpp"
#include "common/base/pacer.hpp"
#include "common/base/words.hpp"
#include "server/http/limits.hpp"
#include "server/http/request_head.hpp"

namespace fracture::http {
namespace {

/// Maximum number of decoded bytes between two polls.
constexpr std::size_t kBlock = kBytesBetweenPolls;
/// Maximum number of encoded bytes between two polls. A stream may consist of blocks that decode to nothing, of which a few
/// bytes each make the decoder build its tables anew (some microseconds).
constexpr std::size_t kEncodedBlock = 16u << 10;
/// 8 MiB, the maximum window size for this coding in RFC 9659.
constexpr int kMaxWindowLog = 23;

enum class Outcome { kWhole, kDamaged, kStopped, kWindow };

/// Calls sink(bytes) -> bool for every decoded block, until it returns false.
template <class Sink>
Outcome each_gzip_block(std::string_view body, Sink sink) {
  z_stream stream{};
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzipOnly) != Z_OK) throw std::bad_alloc();
  const auto end = [](z_stream* s) { inflateEnd(s); };
  const std::unique_ptr<z_stream, decltype(end)> owner(&stream, end);
  std::vector<char> block(kBlock);
  std::size_t read = 0;
  for (;;) {
    const std::size_t piece = std::min(body.size() - read, kEncodedBlock);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(body.data() + read));  // zlib only reads
    stream.avail_in = static_cast<uInt>(piece);
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = kBlock;
    const int result = ::inflate(&stream, Z_NO_FLUSH);
    read += piece - stream.avail_in;
    const std::size_t made = kBlock - stream.avail_out;
    if (!sink(std::string_view(block.data(), made))) return Outcome::kStopped;
    if (result == Z_STREAM_END) {
      if (read == body.size()) return Outcome::kWhole;
      if (inflateReset(&stream) != Z_OK) return Outcome::kDamaged;
    } else if (result != Z_OK || (made == 0 && stream.avail_in == piece)) {
      return Outcome::kDamaged;
    }
  }
}

template <class Sink>
Outcome each_zstd_block(std::string_view body, Sink sink) {
  const auto free = [](ZSTD_DCtx* c) { ZSTD_freeDCtx(c); };
  const std::unique_ptr<ZSTD_DCtx, decltype(free)> context(ZSTD_createDCtx(), free);
  if (!context) throw std::bad_alloc();
  if (ZSTD_isError(ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kMaxWindowLog)))
    throw InternalError("zstd rejected the window limit");
  std::vector<char> block(kBlock);
  ZSTD_inBuffer in{body.data(), 0, 0};
  std::size_t pending = 1;  // 0 at the end of a frame
  while (in.pos < body.size() || pending != 0) {
    const std::size_t before = in.pos;
    in.size = std::min(body.size(), before + kEncodedBlock);
    ZSTD_outBuffer out{block.data(), block.size(), 0};
    pending = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(pending))
      return ZSTD_getErrorCode(pending) == ZSTD_error_frameParameter_windowTooLarge ? Outcome::kWindow
                                                                                    : Outcome::kDamaged;
    if (!sink(std::string_view(block.data(), out.pos))) return Outcome::kStopped;
    if (out.pos == 0 && in.pos == before) return Outcome::kDamaged;
  }
  return Outcome::kWhole;
}

/// Calls `sink(piece)` until it returns false. Pieces can be empty if a step of the decoder produced nothing.
template <class Sink>
Outcome each_block(std::string_view body, ContentCoding coding, Sink sink) {
  const auto counted = [&sink](std::string_view block) {
    count_bulk(block.size());
    return sink(block);
  };
  return coding == ContentCoding::kGzip ? each_gzip_block(body, counted) : each_zstd_block(body, counted);
}

}  // namespace

OrProblem<ContentCoding> content_coding(std::string_view field) {
  if (field.empty() || equals_ignoring_case(field, "identity")) return ContentCoding::kIdentity;
  if (equals_ignoring_case(field, "gzip") || equals_ignoring_case(field, "x-gzip"))
    return ContentCoding::kGzip;
  if (equals_ignoring_case(field, "zstd")) return ContentCoding::kZstd;
  return tl::unexpected<Problem>(
      Problem(HttpProblem::kUnsupportedCoding, "Content-Encoding '" + std::string(field.substr(0, 100)) +
                                                   "' is not supported. Use gzip or zstd, not both.")
          .with("Accept-Encoding", "gzip, zstd"));
}

/// Maximum number of bytes that one byte can decode to. Deflate writes at most 258 bytes per two bits (RFC
/// 1951, section 3.2.5), and zstd a block of 128 KiB per four bytes (RFC 8878, section 3.1.1.2). A body that
/// announces more is damaged.
constexpr std::uint64_t kMostOfDeflate = 1'032, kMostOfZstd = 32'768;

std::uint64_t announced_size(std::string_view body, ContentCoding coding) {
  if (coding == ContentCoding::kZstd) {
    const unsigned long long size = ZSTD_getFrameContentSize(body.data(), body.size());
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) return 0;
    return std::min<std::uint64_t>(size, kMostOfZstd * body.size());
  }
  std::uint64_t size = 0;  // ISIZE (RFC 1952, section 2.3.1) of the last member
  if (coding == ContentCoding::kGzip && body.size() >= 18)
    for (std::size_t k = 1; k <= 4; ++k) size = size << 8 | static_cast<unsigned char>(body[body.size() - k]);
  return std::min<std::uint64_t>(size, kMostOfDeflate * body.size());
}

Decoding decode_body(std::string& body, ContentCoding coding, std::uint64_t limit,
                     MemoryBudget::Reservation& reservation, const Execution& execution,
                     std::uint64_t expected) {
  if (coding == ContentCoding::kIdentity) return {};
  const char* const name = coding == ContentCoding::kGzip ? "gzip" : "zstd";
  std::uint64_t size = 0;
  const Outcome outcome = each_block(body, coding, [&](std::string_view block) {
    execution.poll();
    size += block.size();
    return size <= limit && size <= expected;
  });
  if (outcome == Outcome::kStopped && size <= limit) return {.larger = true};
  if (outcome == Outcome::kStopped)
    return {Problem(HttpProblem::kBodyTooLarge,
                    std::string("The ") + name + " body decodes to more than " + data_size(limit) +
                        ", which is the limit" +
                        (limit > kMaxSmallBody ? " (--max-decoded). Send a smaller mesh."
                                               : " for parameters. Send fewer or shorter ones."))};
  if (outcome == Outcome::kWindow)
    return {Problem(
        HttpProblem::kMalformedCoding,
        "The zstd body needs a window of more than 8 MiB, which is the limit for a Content-Encoding (RFC "
        "9659). Compress it without --long and --ultra.")};
  if (outcome == Outcome::kDamaged)
    return {Problem(HttpProblem::kMalformedCoding, std::string("The body is not a complete ") + name +
                                                       " stream: it is damaged or ends early, after " +
                                                       grouped(size) +
                                                       " decoded bytes. Compress and send it again.")};
  if (!reservation.grow_to(body.size() + size)) return {.no_room = true};
  std::string decoded;
  decoded.reserve(size);
  each_block(body, coding, [&](std::string_view block) {
    execution.poll();
    decoded.append(block);
    return true;
  });
  body = std::move(decoded);
  reservation.shrink_to(body.capacity());
  return {};
}

}  // namespace fracture::http
