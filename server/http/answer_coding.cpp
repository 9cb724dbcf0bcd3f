// Content-Encoding of answers: chooses the coding and compresses.
#define ZSTD_STATIC_LINKING_ONLY  // declares ZSTD_c_stableInBuffer, which every build of the library supports
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <new>

#include "common/base/bulk.hpp"
#include "common/base/text.hpp"
#include "server/http/accept.hpp"
#include "server/http/content_coding.hpp"
#include "server/http/request_head.hpp"

namespace fracture::http {
namespace {

/// Bytes of encoder output between two polls. The encoder can consume some MiB of input for this, if it is
/// all zeros. The input is passed whole, because splitting it would change the output bytes.
constexpr std::size_t kCodedPiece = 1u << 10;

std::vector<std::uint8_t> gzipped(std::span<const std::uint8_t> body, const Execution& execution) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS, kMemory = 8;
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  const auto end = [](z_stream* s) { deflateEnd(s); };
  const std::unique_ptr<z_stream, decltype(end)> owner(&stream, end);
  if (body.size() > std::numeric_limits<uInt>::max())
    throw InternalError("gzip cannot compress 4 GiB or more in one piece");
  std::vector<std::uint8_t> out;
  out.reserve(deflateBound(&stream, static_cast<uLong>(body.size())));
  stream.next_in = const_cast<Bytef*>(body.data());  // zlib only reads
  stream.avail_in = static_cast<uInt>(body.size());
  std::array<Bytef, kCodedPiece> piece;
  for (int result = Z_OK; result != Z_STREAM_END;) {
    execution.poll();
    stream.next_out = piece.data();
    stream.avail_out = static_cast<uInt>(piece.size());
    result = ::deflate(&stream, Z_FINISH);
    if (result != Z_OK && result != Z_STREAM_END) throw InternalError("gzip does not end");
    out.insert(out.end(), piece.data(), stream.next_out);
  }
  out.shrink_to_fit();
  return out;
}

std::vector<std::uint8_t> zstandard(std::span<const std::uint8_t> body, const Execution& execution) {
  constexpr int kLevel = 3;
  const auto free = [](ZSTD_CCtx* c) { ZSTD_freeCCtx(c); };
  const std::unique_ptr<ZSTD_CCtx, decltype(free)> context(ZSTD_createCCtx(), free);
  if (!context) throw std::bad_alloc();
  const auto set = [&](ZSTD_cParameter parameter, int value) {
    if (ZSTD_isError(ZSTD_CCtx_setParameter(context.get(), parameter, value)))
      throw InternalError("zstd rejected a parameter");
  };
  set(ZSTD_c_compressionLevel, kLevel);
  // The encoder then reads the body in place, so the output bytes are those of one-shot compression.
  set(ZSTD_c_stableInBuffer, 1);
  if (ZSTD_isError(ZSTD_CCtx_setPledgedSrcSize(context.get(), body.size()))) throw std::bad_alloc();
  std::vector<std::uint8_t> out;
  out.reserve(ZSTD_compressBound(body.size()));
  ZSTD_inBuffer in{body.data(), body.size(), 0};
  std::array<std::uint8_t, kCodedPiece> piece;
  for (std::size_t left = 1; left != 0;) {
    execution.poll();
    ZSTD_outBuffer made{piece.data(), piece.size(), 0};
    left = ZSTD_compressStream2(context.get(), &made, &in, ZSTD_e_end);
    if (ZSTD_isError(left)) throw std::bad_alloc();
    out.insert(out.end(), piece.data(), piece.data() + made.pos);
  }
  out.shrink_to_fit();
  return out;
}

}  // namespace

std::string_view name_of(ContentCoding coding) {
  return coding == ContentCoding::kGzip ? "gzip" : coding == ContentCoding::kZstd ? "zstd" : "identity";
}

bool CodingWishes::accepts(ContentCoding coding) const {
  return (coding == ContentCoding::kGzip ? gzip : coding == ContentCoding::kZstd ? zstd : identity) > 0;
}

std::optional<ContentCoding> CodingWishes::best() const {
  const int plain = identity_named ? identity : std::min(identity, 1);
  if (zstd > 0 && zstd >= gzip && zstd >= plain) return ContentCoding::kZstd;
  if (gzip > 0 && gzip >= plain) return ContentCoding::kGzip;
  if (identity > 0) return ContentCoding::kIdentity;
  return std::nullopt;
}

CodingWishes coding_wishes(std::string_view accept_encoding) {
  CodingWishes wishes;
  bool gzip = false, zstd = false;
  int others = -1;  // quality of '*'
  while (!accept_encoding.empty()) {
    const std::string_view item = accept_encoding.substr(0, accept_encoding.find(','));
    accept_encoding.remove_prefix(std::min(accept_encoding.size(), item.size() + 1));
    const std::size_t semicolon = item.find(';');
    const std::string_view name = trimmed(item.substr(0, semicolon));
    int q = 1000;
    if (semicolon != std::string_view::npos) {
      const std::string_view weight = trimmed(item.substr(semicolon + 1));
      if (weight.size() < 2 || (weight[0] != 'q' && weight[0] != 'Q') || weight[1] != '=') continue;
      q = thousandths(weight.substr(2));
      if (q < 0) continue;
    }
    if (equals_ignoring_case(name, "gzip") || equals_ignoring_case(name, "x-gzip")) {
      wishes.gzip = q;
      gzip = true;
    } else if (equals_ignoring_case(name, "zstd")) {
      wishes.zstd = q;
      zstd = true;
    } else if (equals_ignoring_case(name, "identity")) {
      wishes.identity = q;
      wishes.identity_named = true;
    } else if (name == "*") {
      others = q;
    }
  }
  if (others >= 0) {
    if (!gzip) wishes.gzip = others;
    if (!zstd) wishes.zstd = others;
    if (!wishes.identity_named && others == 0) wishes.identity = 0;
  }
  return wishes;
}

std::vector<std::uint8_t> encode_body(std::span<const std::uint8_t> body, ContentCoding coding,
                                      const Execution& execution) {
  count_bulk(body.size());
  if (coding == ContentCoding::kGzip) return gzipped(body, execution);
  if (coding == ContentCoding::kZstd) return zstandard(body, execution);
  return {body.begin(), body.end()};
}

}  // namespace fracture::http
