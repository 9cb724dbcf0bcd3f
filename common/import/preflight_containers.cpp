// Checks formats based on XML and ZIP.
#include <cstdint>
#include <string>
#include <string_view>

#include "common/import/preflight.hpp"
#include "common/import/xml_tags.hpp"
#include "common/import/zip_archive.hpp"

namespace fracture::preflight {
namespace {

/// Deeper than any chain of bones. The readers use less than a kilobyte of stack per level.
constexpr std::uint32_t kMaxXmlDepth = 1000;

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Expected<void> check_xml_depth(std::span<const std::byte> bytes) {
  std::uint32_t depth = 0;
  std::size_t too_deep_at = 0;
  xml::for_tags(as_text(bytes), [&](std::string_view tag, std::size_t at) {
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
  xml::for_tags(as_text(bytes), [&](std::string_view tag, std::size_t) {
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
                  ">. It must be COLLADA, irr_scene (Irrlicht), mesh (Irrlicht or Ogre) or WORLD (XGL).");
}

Expected<void> check_zip(std::span<const std::byte> bytes, const ImportLimits& limits) {
  const auto directory = read_zip_directory(bytes, limits.max_decoded_bytes);
  if (!directory) return tl::unexpected<Error>(directory.error());
  return {};
}

}  // namespace fracture::preflight
