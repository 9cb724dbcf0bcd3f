// Decodes EXT_meshopt_compression (bufferViews, with their filters) and KHR_draco_mesh_compression
// (primitives) into plain bufferViews and accessors.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/import/gltf_document.hpp"

namespace fracture {

/// Decodes one compressed view. `extension` is the EXT_meshopt_compression object. `source` is its compressed
/// bytes, already checked against their buffer. Throws Refused.
std::vector<std::uint8_t> decode_meshopt(const nlohmann::json& extension,
                                         std::span<const std::uint8_t> source, const ImportLimits& limits,
                                         const std::string& pointer);

/// Replaces every Draco primitive of the document by plain accessors. The bufferViews must have been checked.
/// Throws Refused.
void decode_draco_primitives(GltfDocument& document, const ImportLimits& limits);

}  // namespace fracture
