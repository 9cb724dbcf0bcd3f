// What is checked before a foreign parser sees a byte. Every check is linear in the file, allocates nothing
// that the file's own numbers decide, and says in words what is wrong and where.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/base/error.hpp"
#include "common/import/import_input.hpp"

namespace fracture::preflight {

struct GlbChunks {
  std::string_view json;
  std::span<const std::byte> binary;  ///< empty when the file has no BIN chunk
};

/// Splits a GLB 2.0 container; chunk lengths are checked in 64 bits against the bytes that are there.
Expected<GlbChunks> split_glb(std::span<const std::byte> bytes);

/// Refuses JSON nested deeper than the limit, without recursion. Not a JSON parser: brackets outside strings
/// only.
Expected<void> check_json_depth(std::string_view json, std::uint32_t max_depth);

/// Binary STL: exactly 84 + 50·n bytes; else it has to be an ASCII "solid" file with facets.
Expected<void> check_stl(std::span<const std::byte> bytes, const ImportLimits& limits);

/// PLY: a well-formed header whose declared elements can fit in the bytes that follow it.
Expected<void> check_ply(std::span<const std::byte> bytes, const ImportLimits& limits);

/// OFF: the declared vertices and faces can fit in the bytes that follow the counts.
Expected<void> check_off(std::span<const std::byte> bytes, const ImportLimits& limits);

/// OBJ: text with at least one face; counts faces against the limit.
Expected<void> check_obj(std::span<const std::byte> bytes, const ImportLimits& limits);

/// BLEND, FBX, DAE, 3DS: the magic of the declared format (their structure, and all of the rest, is the
/// sandboxed parser's business).
Expected<void> check_magic(std::span<const std::byte> bytes, MeshFormat format);

// -- preflight_containers.cpp

/// Refuses XML nested deeper than any scene is (the readers recurse). Not an XML parser: tags outside
/// comments and quotes only.
Expected<void> check_xml_depth(std::span<const std::byte> bytes);

/// Which reader an .xml file is for: COLLADA, Irrlicht (mesh or scene), XGL; kXml itself for Ogre.
/// kUnsupportedFeature naming the root element.
Expected<MeshFormat> kind_of_xml(std::span<const std::byte> bytes);

/// A ZIP archive (3MF, ZAE, PK3, IFCZIP) whose directory is whole and declares no more bytes than may be
/// decoded.
Expected<void> check_zip(std::span<const std::byte> bytes, const ImportLimits& limits);

}  // namespace fracture::preflight
