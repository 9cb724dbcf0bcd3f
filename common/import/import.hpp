// Mesh files in: tinygltf for glTF and GLB, Assimp for everything else. Bytes in, Mesh or a typed error out;
// no file is ever opened by name: the bytes, and the further parts of a multipart upload, are all a loader
// can see.
//
//   bytes ──> preflight (own code: magic, lengths, depth, ranges) ──> loader ──> Mesh ──> finish
//                                                                                          (finite, limits)
//
// The preflight exists because the loaders trust what a file says about itself: tinygltf takes an accessor of
// 2^31 elements, RapidJSON inside Assimp overflows the stack on 400 KB of '[', a 186-byte PLY that declares
// 10^7 vertices costs seconds, and both libraries open any local file that a uri names.
#pragma once

#include <cstddef>
#include <span>

#include "common/base/error.hpp"
#include "common/import/import_input.hpp"
#include "common/mesh/mesh.hpp"

namespace fracture {

/// Coordinates are those of the file after its own node transforms, and Mesh::frame says what they mean as
/// far as the file or its format does (FormatInfo::frame; FBX by its global settings). Wedges with identical
/// positions in the file have bit-identical positions here. Texture coordinates are glTF's (v down) whatever
/// the format. Errors: kEmptyBody, kMalformedMesh (what and at which byte), kUnsupportedFeature (names it),
/// kExternalResource, kTooLarge, kNotFinite (NaN or infinite coordinate, with the vertex), kEmptyMesh.
Expected<Mesh> import_mesh(std::span<const std::byte> bytes, MeshFormat format, const ImportLimits& limits,
                           std::span<const ImportFile> files = {});

}  // namespace fracture
