// Mesh files in: tinygltf for glTF and GLB, Assimp for everything else. Bytes in, Mesh or a typed error out; no file is
// ever opened by name (the bytes are the only file a loader can see).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

enum class MeshFormat { kGlb, kGltf, kObj, kStl, kPly, kOff, kBlend, kFbx, kDae, k3ds };

/// From a file extension without the dot ("glb", "OBJ") or a media type ("model/gltf-binary").
std::optional<MeshFormat> format_from_extension(std::string_view extension);
std::optional<MeshFormat> format_from_media_type(std::string_view media_type);
const char* extension_of(MeshFormat format);
/// glTF, GLB, OBJ, STL, PLY and OFF are always on; the others run much larger parsers and are off by default.
bool enabled_by_default(MeshFormat format);

struct ImportLimits {
  std::uint64_t max_triangles = 4'000'000;
  std::uint64_t max_decoded_bytes = 256ull << 20;
  std::uint32_t max_json_depth = 64;
};

/// Errors: kEmptyBody, kMalformedMesh (what and at which byte), kUnsupportedFeature (names it), kExternalResource,
/// kTooLarge, kNotFinite (NaN or infinite coordinate, with the vertex), kEmptyMesh.
Expected<Mesh> import_mesh(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits);

}  // namespace fracture
