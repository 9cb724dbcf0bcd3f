#include "common/import/gzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <string>

namespace fracture {

bool is_gzip(std::span<const std::byte> bytes) {
  return bytes.size() > 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

Expected<std::vector<std::byte>> gunzip(std::span<const std::byte> bytes, std::uint64_t max_bytes) {
  if (bytes.size() > std::numeric_limits<uInt>::max())
    return fail(ErrorCode::kTooLarge, "The compressed file is larger than 4 GiB.");
  z_stream stream{};
  stream.next_in =
      reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));  // zlib's type; it only reads
  stream.avail_in = static_cast<uInt>(bytes.size());
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzipOnly) != Z_OK) throw InternalError("zlib could not be initialised");
  std::vector<std::byte> out;
  constexpr std::size_t kBlock = 1u << 20;
  int result = Z_OK;
  while (result == Z_OK && out.size() <= max_bytes) {
    const std::size_t before = out.size();
    out.resize(before + kBlock);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + before);
    stream.avail_out = kBlock;
    result = inflate(&stream, Z_NO_FLUSH);
    out.resize(before + kBlock - stream.avail_out);
  }
  inflateEnd(&stream);
  if (out.size() > max_bytes)
    return fail(ErrorCode::kTooLarge, "The file inflates to more than the " + std::to_string(max_bytes) +
                                          " bytes that are allowed.");
  if (result != Z_STREAM_END)
    return fail(ErrorCode::kMalformedMesh, "The compressed file is damaged or truncated after " +
                                               std::to_string(out.size()) + " bytes.");
  return out;
}

}  // namespace fracture
