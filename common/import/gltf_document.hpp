// A glTF document made safe and plain: parsed, every length and index checked in 64 bits against the bytes
// that are there, buffers gathered into one, compressed views and primitives decoded, materials set aside.
// What is left is a core glTF 2.0 document with a single buffer and no uri at all, which is what tinygltf
// gets to see.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/base/remarks.hpp"
#include "common/import/import.hpp"
#include "common/mesh/gltf_component.hpp"
#include "common/mesh/material_library.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

struct GltfDocument {
  nlohmann::json json;
  std::vector<std::uint8_t> binary;  ///< the only buffer; bufferViews refer to it
  MaterialLibrary library;
  std::string copyright;
  Remarks remarks;
};

/// Throws Refused: kMalformedMesh, kUnsupportedFeature, kExternalResource, kTooLarge, each with a JSON
/// pointer.
GltfDocument read_gltf_document(std::span<const std::byte> bytes, MeshFormat format,
                                const ImportLimits& limits, std::span<const ImportFile> files);

// -- helpers of the document's parts (gltf_document.cpp, gltf_compression.cpp, gltf_materials.cpp)

/// The non-negative integer `object[key]`, or `fallback` where the key is absent. Refuses anything else.
std::uint64_t unsigned_at(const nlohmann::json& object, const char* key, std::uint64_t fallback,
                          const std::string& pointer);
inline constexpr std::uint64_t kRequired = ~0ull;  ///< as a fallback: the key has to be there

/// Components of a type ("VEC3"); 0 when unknown.
std::uint64_t component_count(const std::string& type);

/// Appends bytes to the document's buffer at an 8-byte boundary; returns the offset. Refuses beyond the
/// limit.
std::uint64_t append_binary(GltfDocument& document, std::span<const std::uint8_t> bytes,
                            const ImportLimits& limits);

}  // namespace fracture
