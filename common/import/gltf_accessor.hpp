// Accessors of a loaded glTF as numbers: strides, normalized integers, sparse substitution, missing
// bufferViews.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/import/tinygltf_renamed.hpp"

namespace fracture {

/// Every component as a double (exact for all component types; normalized integers as c / max, at least -1,
/// as the specification says), `width` of them for each element. Throws Refused when the accessor does not
/// exist, is of another width, or leaves its view.
std::vector<double> read_accessor(const tinygltf::Model& model, int accessor, int width);

/// Unsigned integers (indices, joints) as they are.
std::vector<std::uint32_t> read_indices(const tinygltf::Model& model, int accessor);

/// Components of the accessor's type (3 for "VEC3").
int accessor_width(const tinygltf::Model& model, int accessor);

}  // namespace fracture
