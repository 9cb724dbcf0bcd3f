#include "common/import/preflight.hpp"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/words.hpp"

namespace fracture::preflight {
namespace {

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (int k = 3; k >= 0; --k) value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + k]);
  return value;
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The first bytes, printable, for error messages about files that are not in the declared format.
std::string beginning_of(std::span<const std::byte> bytes) {
  std::string shown;
  for (const char c : as_text(bytes.first(std::min<std::size_t>(bytes.size(), 16))))
    shown += c >= 0x20 && c < 0x7f ? c : '.';
  return "\"" + shown + "\"";
}

constexpr const char* kSendAgain = "Copy, download or export the file again.";

}  // namespace

Expected<GlbChunks> split_glb(std::span<const std::byte> bytes) {
  constexpr std::uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBin = 0x004e4942;
  if (bytes.size() < 4 || read_u32(bytes, 0) != kMagic) {
    const std::string_view text = as_text(bytes);
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    const bool json = first != std::string_view::npos && text[first] == '{';
    return fail(ErrorCode::kMalformedMesh,
                "This is not a GLB file: it has to begin with \"glTF\" but begins with " +
                    beginning_of(bytes) + "." +
                    (json ? " It looks like JSON: send it as format gltf (model/gltf+json)."
                          : " Name the file's real format, or export it again."));
  }
  if (bytes.size() < 20)
    return fail(ErrorCode::kMalformedMesh,
                "The GLB is incomplete: it has " + counted(bytes.size(), "byte", "bytes") +
                    ", but its header and first chunk take at least 20. " + kSendAgain);
  if (const std::uint32_t version = read_u32(bytes, 4); version != 2)
    return fail(ErrorCode::kUnsupportedFeature, "The GLB has container version " + std::to_string(version) +
                                                    "; only version 2 (glTF 2.0) is supported.");
  const std::uint64_t length = read_u32(bytes, 8);
  if (length > bytes.size())
    return fail(ErrorCode::kMalformedMesh, "The GLB is incomplete: its header (byte 8) declares " +
                                               counted(length, "byte", "bytes") + ", but the file has " +
                                               grouped(bytes.size()) + ". " + kSendAgain);
  GlbChunks chunks;
  bool have_json = false, have_bin = false;
  for (std::uint64_t at = 12; at + 8 <= length;) {
    const std::uint64_t size = read_u32(bytes, at);
    const std::uint32_t type = read_u32(bytes, at + 4);
    if (size > length - at - 8)
      return fail(ErrorCode::kMalformedMesh, "The GLB chunk at byte " + grouped(at) + " declares " +
                                                 counted(size, "byte", "bytes") + ", more than the " +
                                                 grouped(length - at - 8) + " that follow. " + kSendAgain);
    const auto body = bytes.subspan(at + 8, size);
    if (at == 12) {
      if (type != kJson)
        return fail(ErrorCode::kMalformedMesh,
                    "The first chunk of the GLB (byte 12) is not JSON. Export the file again.");
      chunks.json = as_text(body);
      have_json = true;
    } else if (type == kBin && !have_bin) {
      chunks.binary = body;
      have_bin = true;
    }
    at += 8 + size;
  }
  if (!have_json) return fail(ErrorCode::kMalformedMesh, "The GLB has no JSON chunk. Export the file again.");
  return chunks;
}

Expected<void> check_json_depth(std::string_view json, std::uint32_t max_depth) {
  std::uint32_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > max_depth)
        return fail(ErrorCode::kMalformedMesh, "The JSON is nested deeper than " + std::to_string(max_depth) +
                                                   " levels at byte " + std::to_string(i) + ".");
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return {};
}

Expected<void> check_magic(std::span<const std::byte> bytes, MeshFormat format) {
  const std::string_view text = as_text(bytes);
  const auto begins = [&](std::string_view magic) { return text.substr(0, magic.size()) == magic; };
  const auto refuse = [&](const char* name, const char* expected) {
    return fail(ErrorCode::kMalformedMesh, "This file is not in the format " + std::string(name) +
                                               ": it should have " + expected + ", but begins with " +
                                               beginning_of(bytes) +
                                               ". Name the file's real format, or export it again.");
  };
  switch (format) {
    case MeshFormat::kBlend:
      if (!begins("BLENDER")) return refuse("BLEND", "\"BLENDER\" at the beginning");
      return {};
    case MeshFormat::kFbx:
      if (!begins("Kaydara FBX Binary") && text.substr(0, 4096).find("FBX") == std::string_view::npos)
        return refuse("FBX", "\"Kaydara FBX Binary\" or an ASCII FBX header");
      return {};
    case MeshFormat::kDae:
      if (text.substr(0, 65536).find("<COLLADA") == std::string_view::npos)
        return refuse("COLLADA", "a <COLLADA> element");
      return {};
    case MeshFormat::k3ds:
      if (!begins("MM") || bytes.size() < 6 || read_u32(bytes, 2) > bytes.size())
        return refuse("3DS", "a main chunk \"MM\" that fits in the file");
      return {};
    default:
      return {};
  }
}

}  // namespace fracture::preflight
