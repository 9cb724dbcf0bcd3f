// Reads accessors of a loaded glTF as numbers. Handles strides, normalized integers, sparse substitution and
// missing bufferViews.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/import/tinygltf_renamed.hpp"

namespace fracture {

/// Returns every component as a double, `width` per element. Exact for all component types; normalized
/// integers become c / max, at least -1, as in the specification. Throws Refused if the accessor does not
/// exist, has another width, or exceeds its view.
std::vector<double> read_accessor(const tinygltf::Model& model, int accessor, int width);

/// Returns unsigned integers (indices, joints) unchanged.
std::vector<std::uint32_t> read_indices(const tinygltf::Model& model, int accessor);

/// Number of components of the accessor's type (3 for "VEC3").
int accessor_width(const tinygltf::Model& model, int accessor);

}  // namespace fracture
