// Reads OFF (Object File Format of Geomview; Phillips, Levy & Munzner 1993), text and binary.
#pragma once

#include <cstddef>
#include <span>

#include "common/import/import.hpp"

namespace fracture {

/// The header may be OFF with any of the prefixes ST (texture coordinates), C (colours), N (normals), 4 (a fourth, homogeneous
/// coordinate) and n (a stated dimension, which must be 3). The counts may follow on its line, even without a blank, and the
/// number of edges may be missing. In text, a vertex or face begins on a new line; more values on the line are ignored.
/// Colours above 1 are bytes. Colours of faces are ignored and listed in Mesh::dropped.
/// Errors: kMalformedMesh with the line or byte, kUnsupportedFeature (another dimension), kEmptyMesh, kNotFinite, kTooLarge.
Expected<Mesh> import_off(std::span<const std::byte> bytes, const ImportLimits& limits);

}  // namespace fracture
