#include "common/import/decompress.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "common/base/words.hpp"
#include "common/import/limit_words.hpp"

namespace fracture {
namespace {

constexpr std::size_t kBlock = 1u << 20;

tl::unexpected<Error> too_large(std::uint64_t max_bytes) {
  return fail(ErrorCode::kTooLarge, "The decompressed file is larger than the limit of " +
                                        decoded_limit(max_bytes) + ". " + kSmallerMesh);
}
tl::unexpected<Error> damaged(std::size_t good) {
  return fail(ErrorCode::kMalformedMesh, "The compressed file is damaged or cut off after " +
                                             counted(good, "byte", "bytes") + ". Save or send it again.");
}

}  // namespace

bool is_gzip(std::span<const std::byte> bytes) {
  return bytes.size() > 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

bool is_zstd(std::span<const std::byte> bytes) {
  return bytes.size() > 4 && bytes[0] == std::byte{0x28} && bytes[1] == std::byte{0xb5} &&
         bytes[2] == std::byte{0x2f} && bytes[3] == std::byte{0xfd};
}

namespace {

/// `window_bits`: as in inflateInit2().
Expected<std::vector<std::byte>> inflate_stream(std::span<const std::byte> bytes, std::uint64_t max_bytes,
                                                int window_bits) {
  if (bytes.size() > std::numeric_limits<uInt>::max())
    return fail(ErrorCode::kTooLarge,
                "The compressed file is larger than 4 GiB, which is the limit. " + std::string(kSmallerMesh));
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));  // not written by zlib
  stream.avail_in = static_cast<uInt>(bytes.size());
  if (inflateInit2(&stream, window_bits) != Z_OK) throw InternalError("zlib could not be initialised");
  const auto end = [](z_stream* s) { inflateEnd(s); };
  const std::unique_ptr<z_stream, decltype(end)> owner(&stream, end);
  std::vector<std::byte> out;
  int result = Z_OK;
  while (result == Z_OK && out.size() <= max_bytes) {
    // Archives can have very many small files, so no block is larger than the rest, and a byte that shows an excess.
    const std::size_t before = out.size(),
                      block =
                          static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, max_bytes - before)) + 1;
    out.resize(before + block);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + before);
    stream.avail_out = static_cast<uInt>(block);
    result = ::inflate(&stream, Z_NO_FLUSH);
    out.resize(before + block - stream.avail_out);
  }
  if (out.size() > max_bytes) return too_large(max_bytes);
  if (result != Z_STREAM_END) return damaged(out.size());
  return out;
}

}  // namespace

Expected<std::vector<std::byte>> inflate(std::span<const std::byte> bytes, std::uint64_t max_bytes) {
  constexpr int kGzipOrZlib = 32 + MAX_WBITS;
  return inflate_stream(bytes, max_bytes, kGzipOrZlib);
}

Expected<std::vector<std::byte>> inflate_raw(std::span<const std::byte> bytes, std::uint64_t max_bytes) {
  return inflate_stream(bytes, max_bytes, -MAX_WBITS);
}

Expected<std::vector<std::byte>> unzstd(std::span<const std::byte> bytes, std::uint64_t max_bytes) {
  const auto free = [](ZSTD_DStream* s) { ZSTD_freeDStream(s); };
  const std::unique_ptr<ZSTD_DStream, decltype(free)> stream(ZSTD_createDStream(), free);
  if (!stream) throw InternalError("zstd could not be initialised");
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  std::vector<std::byte> out;
  std::size_t pending = 1;  // 0 at the end of a frame
  while ((in.pos < in.size || pending != 0) && out.size() <= max_bytes) {
    const std::size_t before = out.size(), read = in.pos;
    out.resize(before + kBlock);
    ZSTD_outBuffer block{out.data() + before, kBlock, 0};
    pending = ZSTD_decompressStream(stream.get(), &block, &in);
    out.resize(before + block.pos);
    if (ZSTD_isError(pending) || (block.pos == 0 && in.pos == read)) return damaged(out.size());
  }
  if (out.size() > max_bytes) return too_large(max_bytes);
  return out;
}

}  // namespace fracture
