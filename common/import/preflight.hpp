// Checks made before a third-party parser sees any byte. Every check is linear in the file and allocates no
// memory based on numbers in the file. Its errors say what is wrong and where.
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
  std::span<const std::byte> binary;  ///< empty if the file has no BIN chunk
};

/// Splits a GLB 2.0 container. Chunk lengths are checked in 64 bits against the available bytes.
Expected<GlbChunks> split_glb(std::span<const std::byte> bytes);

/// Refuses JSON that is nested deeper than the limit, without recursion. Not a JSON parser: it only looks at
/// brackets outside strings.
Expected<void> check_json_depth(std::string_view json, std::uint32_t max_depth);

/// Checks that BLEND, FBX, DAE and 3DS files begin with the magic of the declared format. The sandboxed
/// parser checks everything else.
Expected<void> check_magic(std::span<const std::byte> bytes, MeshFormat format);

// -- preflight_containers.cpp

/// Refuses XML that is nested deeper than any real scene, because the readers are recursive. Not an XML
/// parser: it only looks at tags outside comments and quotes.
Expected<void> check_xml_depth(std::span<const std::byte> bytes);

/// Returns the reader for an .xml file: COLLADA, Irrlicht (mesh or scene) or XGL; kXml for Ogre. Error:
/// kUnsupportedFeature with the name of the root element.
Expected<MeshFormat> kind_of_xml(std::span<const std::byte> bytes);

/// Checks that a ZIP archive (3MF, ZAE, PK3, IFCZIP) has a complete directory, and that it does not declare
/// more bytes than may be decoded.
Expected<void> check_zip(std::span<const std::byte> bytes, const ImportLimits& limits);

}  // namespace fracture::preflight
