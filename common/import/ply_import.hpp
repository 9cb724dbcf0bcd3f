// Reads PLY (Turk 1994, "The PLY polygon file format"), text and binary, in either byte order.
#pragma once

#include <cstddef>
#include <span>

#include "common/import/import.hpp"

namespace fracture {

/// Properties may have any type and order. These are read:
///   vertex     x y z; nx ny nz; red green blue alpha (or r g b a, diffuse_red, …), where whole numbers are bytes, or 16 bits if
///              their type is; u v (or s t, tx ty, texture_u texture_v)
///   face       the list vertex_indices (or vertex_index), with any number of corners; the list texcoord, a pair for each corner;
///              texnumber
///   tristrips  its list of indices, where -1 begins a new strip
/// Each "comment TextureFile" is a material with that texture. Everything else is skipped by its declared size and listed in
/// Mesh::dropped.
/// Errors: kMalformedMesh with the line or byte, kEmptyMesh (point clouds), kNotFinite, kTooLarge.
Expected<Mesh> import_ply(std::span<const std::byte> bytes, const ImportLimits& limits,
                          std::span<const ImportFile> files);

}  // namespace fracture
