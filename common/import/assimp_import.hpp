// Imports BLEND, FBX, DAE, 3DS and others, if enabled, through Assimp. The declared format determines
// the reader (the fifty readers are never asked to guess). Its IOSystem can open only the upload.
#pragma once

#include <cstddef>
#include <span>

#include "common/import/import.hpp"

namespace fracture {

/// The bytes must have passed the preflight of their format.
Expected<Mesh> import_with_assimp(std::span<const std::byte> bytes, MeshFormat format,
                                  const ImportLimits& limits, std::span<const ImportFile> files);

}  // namespace fracture
