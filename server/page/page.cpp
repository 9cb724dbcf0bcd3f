#include "server/page/page.hpp"

#include <zlib.h>

#include <algorithm>

#include "common/base/error.hpp"

namespace fracture::page {

const File* find(std::string_view path) {
  const std::span<const File> all = files();
  const auto found = std::find_if(all.begin(), all.end(), [path](const File& f) { return f.path == path; });
  return found == all.end() ? nullptr : &*found;
}

std::string plain(const File& file) {
  if (file.plain_size == 0) return {};  // zlib asks for room even then
  std::string bytes(file.plain_size, '\0');
  z_stream stream{};
  constexpr int kGzip = 16;  // zlib.h: a gzip header and trailer are expected
  bool good = inflateInit2(&stream, MAX_WBITS + kGzip) == Z_OK;
  if (good) {
    stream.next_in = const_cast<Bytef*>(file.gzip.data());
    stream.avail_in = static_cast<uInt>(file.gzip.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = static_cast<uInt>(bytes.size());
    good = inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.avail_out == 0;
    inflateEnd(&stream);
  }
  if (!good) throw InternalError("the page's file " + std::string(file.path) + " is damaged");
  return bytes;
}

}  // namespace fracture::page
