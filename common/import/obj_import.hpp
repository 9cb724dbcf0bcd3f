// Imports OBJ and its material libraries. DECISION-obj.md says why this is not a library's work.
#pragma once

#include <cstddef>
#include <span>

#include "common/import/import.hpp"

namespace fracture {

/// The bytes are UTF-8 or an 8-bit encoding. A node is an object or group that has faces; within a node, each run of faces
/// with one material is a separate surface. Wedges are ordered by first use. Positions are the floats nearest to the
/// numbers in the text, less Mesh::frame.offset.
Expected<Mesh> import_obj(std::span<const std::byte> bytes, const ImportLimits& limits,
                          std::span<const ImportFile> files);

}  // namespace fracture
