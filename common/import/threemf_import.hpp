// Imports 3MF packages, also those with ZIP64, with several model parts, and projects of slicers.
#pragma once

#include <cstddef>
#include <span>

#include "common/base/error.hpp"
#include "common/import/import_input.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Reads the build items with their components. Each mesh becomes a node, named after its object, in a group for each object
/// around it. Coordinates stay in the file's unit, which the frame states. Left out, with a note: objects for
/// support, and volumes that a slicer uses as modifiers, negative volumes or supports. Errors: kMalformedMesh,
/// kUnsupportedFeature, kTooLarge, kEmptyMesh.
Expected<Mesh> import_3mf(std::span<const std::byte> bytes, const ImportLimits& limits);

}  // namespace fracture
