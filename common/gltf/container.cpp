#include "common/gltf/container.hpp"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/pages.hpp"

namespace fracture {
namespace {

void append_u32(std::vector<std::uint8_t>& out, std::size_t value) {
  for (const int shift : {0, 8, 16, 24}) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Calls append(begin, size) for all of `large`, in blocks whose size is a multiple of three. Memory that has been read is
/// released, because otherwise the data would be in memory twice.
template <class Bytes, class Append>
void consume(Bytes large, const Execution& execution, const Append& append) {
  constexpr std::size_t kBlock = kBytesBetweenPolls / 3 * 3;
  PagesBehind behind(large.data(), large.size());
  for (std::size_t at = 0; at < large.size(); at += kBlock) {
    execution.poll();
    append(reinterpret_cast<const std::uint8_t*>(large.data()) + at, std::min(kBlock, large.size() - at));
    behind.through(at + kBlock);
  }
}

void append_text(std::vector<std::uint8_t>& out, std::string text, const Execution& execution) {
  consume(std::move(text), execution,
          [&](const std::uint8_t* from, std::size_t size) { out.insert(out.end(), from, from + size); });
}

/// Appends base64 (RFC 4648) without line breaks.
void append_base64(std::vector<std::uint8_t>& out, std::vector<std::uint8_t> bytes,
                   const Execution& execution) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  consume(std::move(bytes), execution, [&](const std::uint8_t* from, std::size_t size) {
    std::size_t at = out.size();
    out.resize(at + (size + 2) / 3 * 4, '=');
    for (std::size_t k = 0; k < size; k += 3, at += 4) {
      const std::size_t here = std::min<std::size_t>(3, size - k);
      unsigned bits = unsigned{from[k]} << 16;
      if (here > 1) bits |= unsigned{from[k + 1]} << 8;
      if (here > 2) bits |= from[k + 2];
      for (std::size_t digit = 0; digit <= here; ++digit)
        out[at + digit] = static_cast<std::uint8_t>(kDigits[bits >> (18 - 6 * digit) & 63]);
    }
  });
}

}  // namespace

void write_views(JsonText& json, const BufferContents& contents) {
  if (contents.views().empty()) return;
  std::size_t offset = 0;
  json.key("bufferViews").begin_array();
  for (const BufferContents::View& view : contents.views()) {
    json.begin_object().member("buffer", 0);
    if (offset > 0) json.member("byteOffset", offset);
    json.member("byteLength", view.size);
    if (view.stride > 0) json.member("byteStride", view.stride);
    if (view.target > 0) json.member("target", view.target);
    json.end_object();
    offset += BufferContents::aligned(view.size);
  }
  json.end_array();
}

std::vector<std::uint8_t> pack_glb(JsonText document, const BufferContents& contents,
                                   const Execution& execution) {
  const std::size_t buffer = contents.size();
  if (buffer > 0)
    document.key("buffers")
        .begin_array()
        .begin_object()
        .member("byteLength", buffer)
        .end_object()
        .end_array();
  std::string json = document.end_object().take();
  json.resize(BufferContents::aligned(json.size()), ' ');
  const std::size_t total = kGlbText + json.size() + (buffer > 0 ? 8 + buffer : 0);
  if (total > std::numeric_limits<std::uint32_t>::max())
    throw InternalError("the GLB would be larger than 4 GiB");
  std::vector<std::uint8_t> glb;
  glb.reserve(total);
  append_u32(glb, 0x46546c67);  // "glTF"
  append_u32(glb, 2);
  append_u32(glb, total);
  append_u32(glb, json.size());
  append_u32(glb, 0x4e4f534a);  // "JSON"
  append_text(glb, std::move(json), execution);
  if (buffer == 0) return glb;
  append_u32(glb, buffer);
  append_u32(glb, 0x004e4942);  // "BIN"
  resize_with_polls(execution, glb, total);
  contents.write(&glb[total - buffer], execution);
  return glb;
}

std::vector<std::uint8_t> pack_gltf(JsonText document, const BufferContents& contents,
                                    const Execution& execution) {
  std::vector<std::uint8_t> buffer;
  if (contents.size() > std::numeric_limits<std::uint32_t>::max())
    throw InternalError("the buffer would be larger than 4 GiB");
  resize_with_polls(execution, buffer, contents.size());
  if (!buffer.empty()) {
    contents.write(buffer.data(), execution);
    document.key("buffers").begin_array().begin_object().member("byteLength", buffer.size());
    document.member("uri", "data:application/octet-stream;base64,");
  }
  std::string json = document.take();
  if (!buffer.empty()) json.pop_back();  // the quotation mark comes after the data
  const std::string_view end = buffer.empty() ? "}" : "\"}]}";
  std::vector<std::uint8_t> out;
  out.reserve(json.size() + (buffer.size() + 2) / 3 * 4 + end.size());
  append_text(out, std::move(json), execution);
  append_base64(out, std::move(buffer), execution);
  out.insert(out.end(), end.begin(), end.end());
  return out;
}

}  // namespace fracture
