#include "common/gltf/container.hpp"

#include <limits>

namespace fracture {
namespace {

std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

void append_u32(std::vector<std::uint8_t>& out, std::size_t value) {
  for (const int shift : {0, 8, 16, 24}) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void append_views(std::vector<std::uint8_t>& out, const std::vector<Accessors::View>& views) {
  for (const Accessors::View& view : views) {
    out.insert(out.end(), view.bytes.data(), view.bytes.data() + view.bytes.size());
    out.resize(out.size() + aligned(view.bytes.size()) - view.bytes.size());
  }
}

/// Appends base64 without line breaks.
void append_base64(std::vector<std::uint8_t>& out, const std::vector<std::uint8_t>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::size_t at = out.size();
  out.resize(at + (bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3, at += 4) {
    const std::size_t left = bytes.size() - k;
    const unsigned second = left > 1 ? bytes[k + 1] : 0u, third = left > 2 ? bytes[k + 2] : 0u;
    const unsigned bits = unsigned{bytes[k]} << 16 | second << 8 | third;
    for (std::size_t digit = 0; digit < 4; ++digit)
      out[at + digit] = digit > left ? std::uint8_t{'='}
                                     : static_cast<std::uint8_t>(kDigits[bits >> (18 - 6 * digit) & 63]);
  }
}

}  // namespace

std::size_t write_views(JsonText& json, const std::vector<Accessors::View>& views) {
  std::size_t offset = 0;
  if (views.empty()) return 0;
  json.key("bufferViews").begin_array();
  for (const Accessors::View& view : views) {
    json.begin_object().member("buffer", 0);
    if (offset > 0) json.member("byteOffset", offset);
    json.member("byteLength", view.bytes.size());
    if (view.stride > 0) json.member("byteStride", view.stride);
    if (view.target > 0) json.member("target", view.target);
    json.end_object();
    offset += aligned(view.bytes.size());
  }
  json.end_array();
  return offset;
}

std::vector<std::uint8_t> pack_glb(JsonText document, const std::vector<Accessors::View>& views,
                                   std::size_t buffer) {
  if (buffer > 0)
    document.key("buffers")
        .begin_array()
        .begin_object()
        .member("byteLength", buffer)
        .end_object()
        .end_array();
  document.end_object();
  const std::string& json = document.text();
  const std::size_t json_size = aligned(json.size());
  const std::size_t total = 12 + 8 + json_size + (buffer > 0 ? 8 + buffer : 0);
  if (total > std::numeric_limits<std::uint32_t>::max())
    throw InternalError("the GLB would be larger than 4 GiB");
  std::vector<std::uint8_t> glb;
  glb.reserve(total);
  append_u32(glb, 0x46546c67);  // "glTF"
  append_u32(glb, 2);
  append_u32(glb, total);
  append_u32(glb, json_size);
  append_u32(glb, 0x4e4f534a);  // "JSON"
  glb.insert(glb.end(), json.begin(), json.end());
  glb.resize(glb.size() + json_size - json.size(), ' ');
  if (buffer == 0) return glb;
  append_u32(glb, buffer);
  append_u32(glb, 0x004e4942);  // "BIN"
  append_views(glb, views);
  return glb;
}

std::vector<std::uint8_t> pack_gltf(JsonText document, const std::vector<Accessors::View>& views,
                                    std::size_t buffer) {
  if (buffer > std::numeric_limits<std::uint32_t>::max())
    throw InternalError("the buffer would be larger than 4 GiB");
  if (buffer > 0) {
    document.key("buffers").begin_array().begin_object().member("byteLength", buffer);
    document.member("uri", "data:application/octet-stream;base64,");
  }
  std::string json = document.take();
  if (buffer == 0) {
    json += '}';
    return {json.begin(), json.end()};
  }
  json.pop_back();  // the quotation mark comes after the data
  std::vector<std::uint8_t> bytes;
  bytes.reserve(buffer);
  append_views(bytes, views);
  static constexpr std::string_view kEnd = "\"}]}";
  std::vector<std::uint8_t> out;
  out.reserve(json.size() + (buffer + 2) / 3 * 4 + kEnd.size());
  out.assign(json.begin(), json.end());
  append_base64(out, bytes);
  out.insert(out.end(), kEnd.begin(), kEnd.end());
  return out;
}

}  // namespace fracture
