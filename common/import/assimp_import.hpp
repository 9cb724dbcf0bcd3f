// OBJ, STL, PLY, OFF and, where enabled, BLEND, FBX, DAE and 3DS through Assimp: the reader is chosen by the
// declared format (never by asking all fifty), under an IOSystem that can open the upload and nothing else.
#pragma once

#include <cstddef>
#include <span>

#include "common/import/import.hpp"

namespace fracture {

/// The bytes have passed the preflight of their format.
Expected<Mesh> import_with_assimp(std::span<const std::byte> bytes, MeshFormat format,
                                  const ImportLimits& limits, std::span<const ImportFile> files);

}  // namespace fracture
