// Reads STL (stereolithography, 3D Systems 1988), text and binary.
#pragma once

#include <cstddef>
#include <span>

#include "common/import/import.hpp"

namespace fracture {

/// A file of exactly 84 + 50 n bytes that declares n triangles is binary, whatever its header says. Text has one part per
/// "solid", named after the first word of its name. Keywords may have any case. Normals are ignored, because the corners state
/// them, and many programs write words in their place. Facets of text may have more than three corners.
/// Facets of binary files may have colours (15 bits, used if the highest bit is 1). If the header contains "COLOR=" (Materialise
/// Magics), red and blue are exchanged, and it states the colour of the other facets.
/// Errors: kMalformedMesh with the line or both counts, kEmptyMesh, kNotFinite, kTooLarge.
Expected<Mesh> import_stl(std::span<const std::byte> bytes, const ImportLimits& limits);

}  // namespace fracture
