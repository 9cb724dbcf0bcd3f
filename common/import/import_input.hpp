// The input of an import and its limits. Also used by code that passes files to a reader in another process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/import/formats.hpp"

namespace fracture {

struct ImportLimits {
  std::uint64_t max_triangles = 4'000'000;         ///< after instancing
  std::uint64_t max_decoded_bytes = 256ull << 20;  ///< decompressed buffers plus the arrays of the Mesh
  std::uint32_t max_json_depth = 64;
};

/// An additional file that the mesh may refer to ("barrel.bin", "textures/wood.png", "barrel.mtl"): a part of a
/// multipart upload. Names are compared literally with the percent-decoded uri, then with its last component.
/// There are no directories.
struct ImportFile {
  std::string name;
  std::span<const std::byte> bytes;
};
/// Total bytes of a mesh and its additional files.
inline std::uint64_t input_bytes(std::span<const std::byte> mesh, std::span<const ImportFile> files) {
  std::uint64_t sum = mesh.size();
  for (const ImportFile& file : files) sum += file.bytes.size();
  return sum;
}

}  // namespace fracture
