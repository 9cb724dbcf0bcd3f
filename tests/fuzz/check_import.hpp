// The checks of the importers' fuzz targets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/import/import.hpp"

namespace fracture::test {

/// Imports the file. Aborts unless the result is a Mesh whose arrays agree with each other, or an Error with a sentence.
inline void check_import(std::span<const std::byte> file, MeshFormat format, const ImportLimits& limits) {
  const Expected<Mesh> mesh = import_mesh(file, format, limits);
  if (!mesh) {
    if (mesh.error().detail.empty()) std::abort();
    return;
  }
  if (mesh->triangles.empty() || mesh->triangles.size() > limits.max_triangles) std::abort();
  if (mesh->material.size() != mesh->triangles.size() || mesh->node.size() != mesh->triangles.size())
    std::abort();
  for (const auto& triangle : mesh->triangles)
    for (const std::uint32_t wedge : triangle)
      if (wedge >= mesh->positions.size()) std::abort();
  for (const auto& uvs : mesh->attributes.uvs)
    if (uvs.size() != mesh->positions.size()) std::abort();
  for (const auto& colors : mesh->attributes.colors)
    if (colors.size() != mesh->positions.size()) std::abort();
}

/// For targets of a single format.
inline void check_import(const std::uint8_t* data, std::size_t size, MeshFormat format) {
  ImportLimits limits;
  limits.max_triangles = 10'000;
  limits.max_decoded_bytes = 16u << 20;
  check_import({reinterpret_cast<const std::byte*>(data), size}, format, limits);
}

}  // namespace fracture::test
