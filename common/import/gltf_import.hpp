// Imports glTF 2.0 and GLB through tinygltf: document (gltf_document.hpp) -> tinygltf -> scene -> surfaces.
#pragma once

#include <cstddef>
#include <span>

#include "common/import/import.hpp"

namespace fracture {

Expected<Mesh> import_gltf(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits,
                           std::span<const ImportFile> files);

}  // namespace fracture
