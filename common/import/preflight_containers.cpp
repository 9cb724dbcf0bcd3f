// Checks formats based on XML and ZIP.
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/import/preflight.hpp"

namespace fracture::preflight {
namespace {

/// Deeper than any chain of bones. The readers use less than a kilobyte of stack per level.
constexpr std::uint32_t kMaxXmlDepth = 1000;

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Returns the position after the tag that begins at `at`: after its '>' outside quotes.
std::size_t end_of_tag(std::string_view text, std::size_t at) {
  char quote = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at + 1;
    }
  }
  return at;
}

/// Calls f(tag with its brackets, its position) for every tag outside comments, CDATA and declarations. f
/// returns whether to continue.
template <class F>
void for_tags(std::string_view text, F&& f) {
  const auto skip_past = [&](std::size_t at, std::string_view end) {
    const std::size_t found = text.find(end, at);
    return found == std::string_view::npos ? text.size() : found + end.size();
  };
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
    if (text.substr(at, 4) == "<!--") {
      at = skip_past(at, "-->");
    } else if (text.substr(at, 9) == "<![CDATA[") {
      at = skip_past(at, "]]>");
    } else if (text.substr(at, 2) == "<?" || text.substr(at, 2) == "<!") {
      at = skip_past(at, ">");
    } else {
      const std::size_t end = end_of_tag(text, at);
      if (!f(text.substr(at, end - at), at)) return;
      at = end;
    }
  }
}

std::uint64_t read_little(std::span<const std::byte> bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t k = count; k-- > 0;) value = value << 8 | std::to_integer<std::uint64_t>(bytes[at + k]);
  return value;
}

}  // namespace

Expected<void> check_xml_depth(std::span<const std::byte> bytes) {
  std::uint32_t depth = 0;
  std::size_t too_deep_at = 0;
  for_tags(as_text(bytes), [&](std::string_view tag, std::size_t at) {
    if (tag.substr(0, 2) == "</")
      depth -= depth > 0;
    else if (tag.size() < 2 || tag[tag.size() - 2] != '/')
      ++depth;
    if (depth > kMaxXmlDepth) too_deep_at = at;
    return depth <= kMaxXmlDepth;
  });
  if (depth <= kMaxXmlDepth) return {};
  return fail(ErrorCode::kMalformedMesh, "The XML is nested deeper than " + std::to_string(kMaxXmlDepth) +
                                             " levels at byte " + std::to_string(too_deep_at) + ".");
}

Expected<MeshFormat> kind_of_xml(std::span<const std::byte> bytes) {
  std::string root, second;
  for_tags(as_text(bytes), [&](std::string_view tag, std::size_t) {
    const std::string name(tag.substr(1, tag.find_first_of(" \t\r\n/>", 1) - 1));
    if (root.empty()) {
      root = name;
      return true;
    }
    second = name;
    return false;
  });
  if (root == "COLLADA") return MeshFormat::kDae;
  if (root == "irr_scene") return MeshFormat::kIrr;
  if (root == "WORLD" || root == "World" || root == "world") return MeshFormat::kXgl;
  if (root == "mesh")  // Ogre stores vertices in these two elements, Irrlicht in buffers
    return second == "submeshes" || second == "sharedgeometry" ? MeshFormat::kXml : MeshFormat::kIrrmesh;
  if (root.empty()) return fail(ErrorCode::kMalformedMesh, "The file is not XML: it contains no elements.");
  for (char& c : root) c = c >= 0x20 && c < 0x7f ? c : '.';
  return fail(ErrorCode::kUnsupportedFeature,
              "The root element of the XML is <" + root.substr(0, 40) +
                  ">. COLLADA, Irrlicht's mesh and irr_scene, Ogre's mesh and XGL's WORLD are supported.");
}

Expected<void> check_zip(std::span<const std::byte> bytes, const ImportLimits& limits) {
  // PKWARE APPNOTE 4.3.16: the end record has 22 bytes and a comment of at most 65,535 bytes.
  constexpr std::size_t kEnd = 22, kEntry = 46;
  const std::string_view text = as_text(bytes);
  const std::size_t tail = text.size() - std::min<std::size_t>(text.size(), kEnd + 65'535);
  const std::size_t end = text.rfind("PK\x05\x06");
  if (text.substr(0, 2) != "PK" || end == std::string_view::npos || end < tail || end + kEnd > text.size())
    return fail(
        ErrorCode::kMalformedMesh,
        "This is not a complete ZIP archive, which this format requires: it has to begin with \"PK\" and "
        "end with its directory.");
  const std::uint64_t entries = read_little(bytes, end + 10, 2);
  std::uint64_t at = read_little(bytes, end + 16, 4), decoded = 0;
  for (std::uint64_t k = 0; k < entries; ++k) {
    if (at + kEntry > end || text.substr(at, 4) != "PK\x01\x02")
      return fail(ErrorCode::kMalformedMesh, "The ZIP directory has no complete entry " + std::to_string(k) +
                                                 " of " + std::to_string(entries) + " at byte " +
                                                 std::to_string(at) + ".");
    decoded += read_little(bytes, at + 24, 4);
    if (decoded > limits.max_decoded_bytes)
      return fail(ErrorCode::kTooLarge, "The ZIP archive declares at least " + std::to_string(decoded) +
                                            " bytes of content; the limit is " +
                                            std::to_string(limits.max_decoded_bytes) + ".");
    at += kEntry + read_little(bytes, at + 28, 2) + read_little(bytes, at + 30, 2) +
          read_little(bytes, at + 32, 2);
  }
  return {};
}

}  // namespace fracture::preflight
