#include "common/gltf/container.hpp"

#include <algorithm>
#include <limits>
#include <string_view>

namespace fracture {
namespace {

std::size_t aligned(std::size_t size) { return (size + 3) / 4 * 4; }

void append_u32(std::vector<std::uint8_t>& out, std::size_t value) {
  for (const int shift : {0, 8, 16, 24}) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// visit(bytes, count) for all bytes of the views, each 4-byte aligned, which are emptied on the way.
template <class Visit>
void each_block(std::vector<Accessors::View>& views, const Execution& execution, const Visit& visit) {
  constexpr std::uint8_t kZeros[4] = {};
  for (Accessors::View& view : views) {
    const std::size_t size = view.bytes.size();
    for (std::vector<std::uint8_t>& chunk : view.bytes.chunks()) {
      for (std::size_t at = 0; at < chunk.size(); at += kBytesBetweenPolls) {
        execution.poll();
        visit(chunk.data() + at, std::min(kBytesBetweenPolls, chunk.size() - at));
      }
      chunk = {};
    }
    if (aligned(size) > size) visit(kZeros, aligned(size) - size);
  }
}

void append_text(std::vector<std::uint8_t>& out, std::string_view text, const Execution& execution) {
  for (std::size_t at = 0; at < text.size(); at += kBytesBetweenPolls) {
    execution.poll();
    const std::string_view block = text.substr(at, kBytesBetweenPolls);
    out.insert(out.end(), block.begin(), block.end());
  }
}

/// Base64 (RFC 4648) of bytes that come in blocks, without line breaks.
class Base64 {
 public:
  explicit Base64(std::vector<std::uint8_t>& out) : out_(out) {}

  void append(const std::uint8_t* bytes, std::size_t count) {
    for (; size_ > 0 && count > 0; --count) hold(*bytes++);
    const std::size_t whole = count / 3;
    std::size_t at = out_.size();
    out_.resize(at + 4 * whole);
    for (std::size_t k = 0; k < whole; ++k, bytes += 3, at += 4) encode(bytes, &out_[at]);
    for (count %= 3; count > 0; --count) hold(*bytes++);
  }
  void finish() {
    if (size_ == 0) return;
    std::fill(held_ + size_, held_ + 3, std::uint8_t{0});
    std::uint8_t four[4];
    encode(held_, four);
    std::fill(four + size_ + 1, four + 4, std::uint8_t{'='});
    out_.insert(out_.end(), four, four + 4);
  }

 private:
  void hold(std::uint8_t byte) {
    held_[size_++] = byte;
    if (size_ < 3) return;
    size_ = 0;
    append(held_, 3);
  }
  static void encode(const std::uint8_t* three, std::uint8_t* four) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned bits = unsigned{three[0]} << 16 | unsigned{three[1]} << 8 | three[2];
    for (int digit = 0; digit < 4; ++digit)
      four[digit] = static_cast<std::uint8_t>(kDigits[bits >> (18 - 6 * digit) & 63]);
  }

  std::vector<std::uint8_t>& out_;
  std::uint8_t held_[3] = {};
  std::size_t size_ = 0;  // of what is held: a group that is not complete
};

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

std::vector<std::uint8_t> pack_glb(JsonText document, std::vector<Accessors::View>& views, std::size_t buffer,
                                   const Execution& execution) {
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
  append_text(glb, json, execution);
  glb.resize(glb.size() + json_size - json.size(), ' ');
  if (buffer == 0) return glb;
  append_u32(glb, buffer);
  append_u32(glb, 0x004e4942);  // "BIN"
  each_block(views, execution, [&](const std::uint8_t* bytes, std::size_t count) {
    glb.insert(glb.end(), bytes, bytes + count);
  });
  return glb;
}

std::vector<std::uint8_t> pack_gltf(JsonText document, std::vector<Accessors::View>& views,
                                    std::size_t buffer, const Execution& execution) {
  if (buffer > std::numeric_limits<std::uint32_t>::max())
    throw InternalError("the buffer would be larger than 4 GiB");
  if (buffer > 0) {
    document.key("buffers").begin_array().begin_object().member("byteLength", buffer);
    document.member("uri", "data:application/octet-stream;base64,");
  }
  std::string_view json = document.text();
  if (buffer > 0) json.remove_suffix(1);  // the quotation mark comes after the data
  const std::string_view end = buffer > 0 ? "\"}]}" : "}";
  std::vector<std::uint8_t> out;
  out.reserve(json.size() + (buffer + 2) / 3 * 4 + end.size());
  append_text(out, json, execution);
  Base64 base64(out);
  each_block(views, execution,
             [&](const std::uint8_t* bytes, std::size_t count) { base64.append(bytes, count); });
  base64.finish();
  append_text(out, end, execution);
  return out;
}

}  // namespace fracture
