// Turns a glTF document into a safe and plain one. Parses it, checks every length and index in 64 bits
// against the available bytes, gathers all buffers into one, decodes compressed views and primitives, and
// extracts the materials. The result is a core glTF 2.0 document with a single buffer and no uris. tinygltf
// sees only this document.
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
  std::vector<Dropped> dropped;  ///< things outside the scene graph that the answer does not contain
  Vec3d center{};                ///< CESIUM_RTC: to add to the translations of the scene's nodes
};

/// Throws Refused with kMalformedMesh, kUnsupportedFeature, kExternalResource or kTooLarge, each with a JSON
/// pointer.
GltfDocument read_gltf_document(std::span<const std::byte> bytes, MeshFormat format,
                                const ImportLimits& limits, std::span<const ImportFile> files);

// -- helpers for the parts of a document (gltf_document.cpp, gltf_compression.cpp, gltf_materials.cpp)

/// Returns the non-negative integer `object[key]`, or `fallback` if the key is absent. Refuses anything else.
std::uint64_t unsigned_at(const nlohmann::json& object, const char* key, std::uint64_t fallback,
                          const std::string& pointer);
inline constexpr std::uint64_t kRequired = ~0ull;  ///< as a fallback: the key is required

/// Number of components of a type ("VEC3"); 0 if the type is unknown.
std::uint64_t component_count(const std::string& type);

/// Appends bytes to the document's buffer at an 8-byte boundary, and returns the offset. Refuses to exceed
/// the limit.
std::uint64_t append_binary(GltfDocument& document, std::span<const std::uint8_t> bytes,
                            const ImportLimits& limits);

}  // namespace fracture
